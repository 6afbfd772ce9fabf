"""What boats and operators say to each other: messages, keys, codec, the bus and its Zenoh session."""
