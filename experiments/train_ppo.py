"""Train a small policy on neural observations by PPO, or replay one: ``colias train``; ``--help`` tells.

``python experiments/train_ppo.py --env Fixation`` trains; ``--replay FILE`` plays what was learnt, into Rerun.
"""

import sys

if __name__ == "__main__":
    from experiments.bench.cli.entry import main

    sys.argv[1:1] = ["train"]
    main()
