"""The base of every section of a scene."""

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """One section of a scene: frozen fields; unknown ones are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)
