"""NMEA 0183: GNSS receivers, compasses and turn indicators, and AIS receivers on the same line."""
