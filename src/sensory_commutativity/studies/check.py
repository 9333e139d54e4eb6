"""Everything that can be told of a configuration before any job."""

from __future__ import annotations

from .config import Config


def check_run(config: Config) -> None:
    """Raise UserError for a folder that cannot be written to, a robot or scene that cannot be read, and rooms too small for what is in them."""
    # imported here: the workflow reads this module before every job, and a job on a cluster need not try all this again
    from ..storage.folders import check_writable
    from .apartment.builders import check_apartment
    from .flatland.builders import check_rooms
    from .navigation.builders import check_navigation
    from .objects.builders import check_masks

    check_writable(config.folder)
    check_rooms(config)
    check_apartment(config)
    check_masks(config)
    check_navigation(config)
