"""Tools and their edges in the store: events kept, and which edge a job means."""
