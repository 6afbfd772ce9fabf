"""One boat's process: `step`, the picture of the others, orders, troubles, the loop."""
