#include "raytrace/lines/tidy.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/line_runs.h"
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
