"""Tables of any columns, CSV or workbook: what their columns mean is a mapping, proposed from the headings."""
