"""The paper's shares: filled exactly, in the order of trials, the rest flagged and kept."""

from __future__ import annotations

import numpy as np

from sdh_sim.campaign import paper_preset


def rows(outcomes: dict[str, list[str]]) -> list[dict]:
    found = []
    for name, failures in outcomes.items():
        for failure in failures:
            found.append({"trial": len(found), "object": name, "success": failure == "none",
                          "failure": failure})  # fmt: skip
    return found


def test_shares_are_the_papers():
    assert sum(paper_preset.PAPER_SHARES.values()) * 2 == 584


def test_surplus_is_what_comes_after_the_share():
    many = rows({"box": ["none", "dropped"] * 100, "oval_bottle": ["slipped"] * 3})
    shuffled = [many[k] for k in np.random.default_rng(0).permutation(len(many))]
    marked = paper_preset.mark_surplus(shuffled)
    assert [row["trial"] for row in marked] == list(range(len(many)))
    kept = [row for row in marked if not row["surplus"]]
    assert sum(row["object"] == "box" and row["success"] for row in kept) == 67
    assert sum(row["object"] == "box" and not row["success"] for row in kept) == 67
    assert max(row["trial"] for row in kept if row["object"] == "box") == 133
    assert sum(row["object"] == "oval_bottle" for row in kept) == 3


def test_trials_without_truth_fill_nothing():
    marked = paper_preset.mark_surplus(rows({"box": ["error", "unstable_simulation", "none"]}))
    assert [row["surplus"] for row in marked] == [
        False,
        False,
        False,
    ]  # they count as what they are
    share = paper_preset.shares(marked)["box"]
    assert (share.stable, share.unstable, share.full) == (1, 0, False)


def test_next_round_follows_the_scarcer_outcome():
    full = dict.fromkeys(paper_preset.PAPER_SHARES, paper_preset.Share(50, 60, 90))
    assert paper_preset.trials_needed(full, 150) == 150
    # 20 of 100 stable: 50 need about 250, a tenth more to be sure, but no more than double.
    short = {**full, "box": paper_preset.Share(50, 40, 60)}
    assert 100 < paper_preset.trials_needed(short, 100) <= 135
    assert paper_preset.trials_needed({**full, "box": paper_preset.Share(50, 20, 80)}, 100) == 200
    assert (
        paper_preset.trials_needed({**full, "box": paper_preset.Share(50, 0, 100)}, 2900)
        == paper_preset.MOST
    )
