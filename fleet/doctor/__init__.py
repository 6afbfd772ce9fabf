"""A boat looked at as a whole before it sails: what is found, and what to do about it."""
