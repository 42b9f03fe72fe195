"""The paper's claims, reproduced and reported."""
