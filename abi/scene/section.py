"""The base of every section of a scene, and of files about scenes, such as lessons."""

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """One section of a file: frozen, finite fields; unknown ones are refused."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_default=True, allow_inf_nan=False
    )
