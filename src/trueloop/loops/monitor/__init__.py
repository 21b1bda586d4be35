"""Quality monitor: charts of a series with the causes of alarms, certificates of parts, checks of gauges."""
