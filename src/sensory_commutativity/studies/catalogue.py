"""Which figures there are, and which tables each is drawn from. Imports nothing heavy: the workflow reads it."""

from __future__ import annotations

COMPARED = (
    "flatland_scp", "flatland_comparisons", "flatland_trends", "flatland_commutation", "flatland_baselines", "flatland_alternatives",
    "apartment_scp", "apartment_hierarchy", "apartment_order", "mask_summary", "mask_comparisons",
    "mask_discoveries", "local_scp_summary", "navigation_summary", "navigation_comparisons",
)  # fmt: skip
"""Tables that the table paper_comparison is made from."""

FIGURES: dict[str, tuple[str, ...]] = {
    "flatland_world": (),
    "flatland_scp": ("flatland_scp", "flatland_baselines", "flatland_alternatives"),
    "flatland_comparisons": ("flatland_comparisons",),
    "flatland_combinations": ("flatland_scp", "flatland_trends"),
    "flatland_commutation": ("flatland_commutation",),
    "flatland_sensitivity": ("flatland_sensitivity",),
    "flatland_free_space": ("flatland_scp",),
    "apartment_world": (),
    "apartment_plans": (),
    "apartment_scp": ("apartment_scp",),
    "apartment_order": ("apartment_scp", "apartment_order"),
    "apartment_interaction": ("apartment_interaction",),
    "mask_dataset": ("mask_examples",),
    "mask_inference": ("mask_examples",),
    "mask_generalisation": ("mask_examples",),
    "mask_confusion": ("mask_scores",),
    "mask_iou": ("mask_scores", "mask_summary"),
    "mask_curves": ("mask_curves",),
    "mask_discoveries": ("mask_discoveries",),
    "local_scp": ("local_scp", "local_scp_summary"),
    "navigation_learning": ("navigation_curves", "navigation_checkpoints"),
    "navigation_action_spaces": ("navigation_action_spaces",),
    "navigation_scores": ("navigation_scores", "navigation_summary"),
    "navigation_comparisons": ("navigation_comparisons",),
    "navigation_survival": ("navigation_survival", "navigation_scores", "navigation_comparisons"),
    "navigation_profiles": ("navigation_profiles",),
    "navigation_power": ("navigation_power", "navigation_calibration", "navigation_comparisons"),
    "paper_comparison": ("paper_comparison",),
}
"""Figure -> tables. A figure is drawn by the module of its name, which has a function ``draw(tables, config)`` that returns a matplotlib figure."""

ARRAYS = {"mask_examples": "h5"}
"""What lies beside the tables, in files that end so, and is no table but arrays."""


def source_file(name: str) -> str:
    """File of a table or of arrays in the folder of the tables."""
    return f"{name}.{ARRAYS.get(name, 'parquet')}"
