"""Everything about a configuration that can be checked before any job runs."""

from __future__ import annotations

from ..storage.folders import check_writable
from .apartment.builders import check_apartment
from .config import Config
from .flatland.builders import check_rooms
from .gallery.builders import check_gallery
from .navigation.builders import check_navigation
from .objects.builders import check_masks


def check_run(config: Config) -> None:
    """Check the folder of the results, robots, scenes, and that objects fit into their rooms.

    Raises
    ------
    UserError
    """
    check_writable(config.folder, "set the key 'results' to a folder that you may write to")
    check_rooms(config)
    check_apartment(config)
    check_gallery(config)
    check_masks(config)
    check_navigation(config)
