"""From a project file to a loop's values, and on to finished outputs."""
