"""Quality monitor from the store: charts, certificates, checks of gauges, and their files."""
