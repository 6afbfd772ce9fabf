"""The world that agents sail in, and the processes of a simulation on one machine."""
