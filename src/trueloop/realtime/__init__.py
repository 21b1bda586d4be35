"""What a control corrects by itself, period by period: the image of a model and a table, and how a run is judged."""
