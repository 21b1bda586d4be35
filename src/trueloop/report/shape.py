"""What a page says, as JSON: the shapes of its parts. Their fields and the texts below them make the JSON schema."""

from pydantic import BaseModel, ConfigDict


class Shape(BaseModel):
    """A table of named values. Numbers that are not known are null."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        use_attribute_docstrings=True,
        allow_inf_nan=False,
        ser_json_inf_nan="null",
        defer_build=True,
    )
