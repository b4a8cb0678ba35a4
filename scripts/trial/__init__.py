"""Trial: random scenarios and bad inputs, each in a process of its own, and how each ending is judged."""
