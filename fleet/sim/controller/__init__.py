"""A simulated thruster controller: what the `can` driver talks to, on a real bus, with a simulated hull behind it."""
