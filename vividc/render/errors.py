"""The error of scenes, cameras and crops that cannot be used."""

from __future__ import annotations

from vividc.errors import VividcError


class SceneError(VividcError):
    """A scene or camera file is unusable, or a crop does not fit its image or the scratchpad."""
