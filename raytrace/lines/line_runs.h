#pragma once

#include "raytrace/lines/feature_line.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Points [begin, end) of a line.
struct Run {
    std::size_t begin, end;
};

/// In the picture, pixels.
float length_of(const std::vector<LinePoint>& points, const Run& run);

/// Runs of points that are all marked or all not, in their order.
std::vector<Run> runs_of(const std::vector<std::uint8_t>& marked);

/// The first point of a loop becomes one where a run of marked points begins, so that no run is cut
/// in two at its seam.
void open_at_mark(FeatureLine& line, std::vector<std::uint8_t>& marked);

/// Marks or unmarks the runs for which wanted(run, whether it is marked) says so, if there are
/// several; a loop that is open at a mark before is afterwards.
template <class Wanted>
void flip_runs(FeatureLine& line, std::vector<std::uint8_t>& marked, const Wanted& wanted) {
    const std::vector<Run> runs = runs_of(marked);
    if (runs.size() < 2) return;
    for (const Run& run : runs) {
        const std::uint8_t mark = marked[run.begin];
        if (wanted(run, mark != 0))
            std::fill(marked.begin() + static_cast<std::ptrdiff_t>(run.begin),
                      marked.begin() + static_cast<std::ptrdiff_t>(run.end),
                      mark ? std::uint8_t{0} : std::uint8_t{1});
    }
    open_at_mark(line, marked);
}

/// Whether others lie to both sides of a run; of a loop they do.
inline bool is_between(const FeatureLine& line, const Run& run) {
    return line.closed || (run.begin > 0 && run.end < line.points.size());
}

/// What is left of a line without the runs that are marked;
/// each rest takes `overlap` points of what it leaves.
void add_unmarked(FeatureLine line, const std::vector<std::uint8_t>& marked, std::size_t overlap,
                  std::vector<FeatureLine>& out);

}  // namespace slim
