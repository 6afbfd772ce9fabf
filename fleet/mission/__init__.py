"""What the fleet is to do: mission files, their validation, the ready missions."""
