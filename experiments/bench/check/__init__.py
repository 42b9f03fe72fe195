"""The laws that models, stimuli and arenas keep: what ``colias check`` tries, and the tests on all that ship."""
