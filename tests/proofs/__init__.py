"""Long proofs: figures that take minutes, each reproduced by `python -m tests.proofs.<name>`; see docs/proofs.md."""
