"""A simulated laser scanner: hulls as its beams meet them, told in SCIP 2.0 over TCP."""
