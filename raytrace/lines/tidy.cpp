#include "raytrace/lines/tidy.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/point_grid.h"
#include "raytrace/lines/select.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace slim {
namespace {

constexpr float kClear = 0.5f;     ///< evidence
constexpr float kUnclear = 12;     ///< pixels: an unclear part as long cuts a line
constexpr float kBeside = 1.9f;    ///< pixels: lines so near are one
constexpr float kCrossing = 5;     ///< pixels: lines that cross or meet are that near for so long

/// Points [begin, end) of a line.
struct Run {
    std::size_t begin, end;
};

float length_of(const std::vector<LinePoint>& points, const Run& run) {
    float px = 0;
    for (std::size_t i = run.begin + 1; i < run.end; ++i)
        px += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
    return px;
}

/// Runs of points that are all marked or all not, in their order.
std::vector<Run> runs_of(const std::vector<std::uint8_t>& marked) {
    std::vector<Run> runs;
    for (std::size_t i = 0; i < marked.size(); ++i)
        if (i == 0 || marked[i] != marked[i - 1])
            runs.push_back({i, i + 1});
        else
            runs.back().end = i + 1;
    return runs;
}

/// A loop is opened where a run of marked points begins, so that no run is cut in two at its seam.
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

/// What is left of a line without the runs that are marked;
/// each rest takes `overlap` points of what it leaves.
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

/// Takes unclear ends away, and unclear parts that are long.
std::vector<FeatureLine> clear_parts(std::vector<FeatureLine> lines, float px) {
    std::vector<FeatureLine> out;
    for (FeatureLine& line : lines) {
        std::vector<std::uint8_t> unclear;
        for (const LinePoint& p : line.points) unclear.push_back(p.evidence < kClear ? 1 : 0);
        open_at_mark(line, unclear);
        const std::vector<Run> runs = runs_of(unclear);
        for (const Run& run : runs) {
            const bool at_end = !line.closed && (run.begin == 0 || run.end == unclear.size());
            if (unclear[run.begin] && runs.size() > 1 && !at_end &&
                length_of(line.points, run) < kUnclear * px)
                std::fill(unclear.begin() + static_cast<std::ptrdiff_t>(run.begin),
                          unclear.begin() + static_cast<std::ptrdiff_t>(run.end), std::uint8_t{0});
        }
        add_unmarked(std::move(line), unclear, 0, out);
    }
    return out;
}

/// Longest first.
std::vector<std::size_t> by_length(std::vector<FeatureLine>& lines) {
    for (FeatureLine& line : lines) measure_line(line);
    std::vector<std::size_t> order(lines.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return lines[a].length_px > lines[b].length_px;
    });
    return order;
}

/// Leaves to a longer line what runs beside it.
std::vector<FeatureLine> without_doubles(std::vector<FeatureLine> lines, float px) {
    std::size_t n = 0;
    for (const FeatureLine& line : lines) n += line.points.size();
    PointGrid placed(kBeside * px, n);
    std::vector<FeatureLine> out;
    for (const std::size_t i : by_length(lines)) {
        FeatureLine& line = lines[i];
        std::vector<std::uint8_t> beside;
        for (const LinePoint& p : line.points) {
            bool near = false;
            placed.for_each(p.x, p.y, [&](std::uint32_t, float) { near = true; });
            beside.push_back(near ? 1 : 0);
        }
        open_at_mark(line, beside);
        const std::vector<Run> runs = runs_of(beside);
        for (const Run& run : runs)
            if (beside[run.begin] && runs.size() > 1 &&
                length_of(line.points, run) < kCrossing * px)
                std::fill(beside.begin() + static_cast<std::ptrdiff_t>(run.begin),
                          beside.begin() + static_cast<std::ptrdiff_t>(run.end), std::uint8_t{0});
        for (const LinePoint& p : line.points) placed.add(p.x, p.y, 0);
        add_unmarked(std::move(line), beside, 1, out);
    }
    return out;
}

}  // namespace

std::vector<FeatureLine> tidy_contours(std::vector<FeatureLine> lines, float px) {
    return join_ends(without_doubles(clear_parts(std::move(lines), px), px), px);
}

}  // namespace slim
