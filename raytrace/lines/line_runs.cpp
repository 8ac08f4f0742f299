#include "raytrace/lines/line_runs.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {

float length_of(const std::vector<LinePoint>& points, const Run& run) {
    float px = 0;
    for (std::size_t i = run.begin + 1; i < run.end; ++i)
        px += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
    return px;
}

std::vector<Run> runs_of(const std::vector<std::uint8_t>& marked) {
    std::vector<Run> runs;
    for (std::size_t i = 0; i < marked.size(); ++i)
        if (i == 0 || marked[i] != marked[i - 1])
            runs.push_back({i, i + 1});
        else
            runs.back().end = i + 1;
    return runs;
}

void open_at_mark(FeatureLine& line, std::vector<std::uint8_t>& marked) {
    if (!line.closed) return;
    std::ptrdiff_t first = 0;
    const auto n = static_cast<std::ptrdiff_t>(marked.size());
    const auto begins = [&](std::ptrdiff_t i) {
        return marked[static_cast<std::size_t>(i)] != 0 &&
               marked[static_cast<std::size_t>((i + n - 1) % n)] == 0;
    };
    while (first < n && !begins(first)) ++first;
    if (first == n) return;
    std::rotate(line.points.begin(), line.points.begin() + first, line.points.end());
    std::rotate(marked.begin(), marked.begin() + first, marked.end());
}

void add_unmarked(FeatureLine line, const std::vector<std::uint8_t>& marked, std::size_t overlap,
                  std::vector<FeatureLine>& out) {
    const std::vector<Run> runs = runs_of(marked);
    if (runs.size() == 1 && !marked[0]) return out.push_back(std::move(line));
    for (const Run& run : runs) {
        if (marked[run.begin]) continue;
        const std::size_t begin = run.begin - std::min(run.begin, overlap),
                          end = std::min(marked.size(), run.end + overlap);
        if (end - begin < 2) continue;
        FeatureLine piece;
        piece.kind = line.kind;
        piece.points.assign(line.points.begin() + static_cast<std::ptrdiff_t>(begin),
                            line.points.begin() + static_cast<std::ptrdiff_t>(end));
        out.push_back(std::move(piece));
    }
}

}  // namespace slim
