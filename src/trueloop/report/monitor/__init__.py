"""Quality monitor: charts, certificates and checks of gauges as JSON, lines for a terminal, pages."""
