"""Credentials: an authority of the fleet's own, a key and a certificate for each station, one signed roster."""
