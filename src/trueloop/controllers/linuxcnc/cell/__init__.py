"""The cell client beside LinuxCNC: it runs what the service offers, each run once, and loses nothing of it."""
