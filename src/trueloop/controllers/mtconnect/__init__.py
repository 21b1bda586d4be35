"""MTConnect: an adapter that reports LinuxCNC's state to agents, and a reader of agents."""
