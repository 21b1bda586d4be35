"""What a shop does with parts: orders and their routes, runs on machines, and the facts known of each run."""
