"""Q-DAS ASCII transfer format (AQDEF), `.dfq`, or plan and values apart in `.dfd` and `.dfx`: read and written."""
