"""AIS: other vessels' own words, heard and, for plotters, said."""
