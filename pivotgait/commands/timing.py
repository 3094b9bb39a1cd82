"""``bench``: timings against peers, as ratios in one run."""

from __future__ import annotations

import os
import platform

from pivotgait.commands.output import Output


def run_bench(quick: bool, out: Output) -> int:
    """Run every benchmark and print its table."""
    from pivotgait.benchmarks import (
        allocation_rows,
        control_rows,
        feasibility_rows,
        import_rows,
        relocation_rows,
        removal_rows,
        simulation_rows,
        sweep_rows,
    )

    rows = []
    jobs = (
        allocation_rows,
        feasibility_rows,
        removal_rows,
        relocation_rows,
        control_rows,
        simulation_rows,
        sweep_rows,
        import_rows,
    )
    with out.progress("measuring", len(jobs)) as bar:
        for job in jobs:
            rows += job(quick)
            bar.advance(bar.task_ids[0])
    machine = {
        "machine": platform.machine(),
        "processor": platform.processor() or "unknown",
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "load_1min": round(os.getloadavg()[0], 2),
    }
    columns = [
        ("what", "left"),
        ("ours", "right"),
        ("peer", "left"),
        ("peer's", "right"),
        ("ratio", "right"),
        ("peer builds in", "right"),
    ]
    table = []
    for row in rows:
        ours, peer, build = row["ours_s"], row.get("peer_s"), row.get("peer_build_s")
        table.append(
            (
                row["name"],
                "-" if ours is None else f"{1e3 * ours:.3f} ms",
                row.get("peer") or "-",
                "-" if peer is None else f"{1e3 * peer:.3f} ms",
                "-" if row.get("ratio") is None else f"{row['ratio']:.2f}",
                "-" if build is None else f"{1e3 * build:.0f} ms",
            )
        )
    out.table("pivotgait bench (ratio = peer / ours, above 1 when we are faster)", columns, table)
    out.emit({"machine": machine, "rows": rows})
    return 0
