#include "pipeline/measure/apart.h"

#include "pipeline/box_text.h"
#include "slim/base/error.h"

#include <algorithm>

namespace slim {
namespace {

/// Clouds of one thing in one unit seldom differ more, by parts that are missing or strays.
constexpr double kOtherUnit = 8;

std::string likely_cause(const PlacedFile& cloud, const PlacedFile& model) {
    const double c = cloud.box.diagonal(), m = model.box.diagonal();
    if (c > 0 && m > 0 && std::max(c / m, m / c) >= kOtherUnit)
        return fmt::format(
            "the {} is {:.4g} times as large: are both in the same unit? Scale one, or build the "
            "model of a cloud in this one's unit",
            c > m ? "cloud" : "model", std::max(c / m, m / c));
    if (!meet(cloud.box, model.box))
        return fmt::format(
            "from the model's centre to the cloud's it is {}: are both in the same frame? Move the "
            "cloud back (an offset that a program took off?), or build the model of a cloud in "
            "this one's frame",
            point_text(cloud.box.center() - model.box.center()));
    return "their boxes meet, their surfaces do not: is one of them turned, or mirrored, or of "
           "something else?";
}

}  // namespace

bool meet(const Bbox& a, const Bbox& b) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (a.lo[axis] > b.hi[axis] || b.lo[axis] > a.hi[axis]) return false;
    return true;
}

PlacedFile placed(const std::string& path, const ModelHeader& header) {
    return {path, {header.bounds.lo + header.origin, header.bounds.hi + header.origin}};
}

void refuse_apart(const PlacedFile& cloud, const PlacedFile& model, std::uint64_t n_points) {
    throw NumericalError(
        fmt::format("{}: {} has no surface in reach of {}; nothing is written. Cloud from {}, "
                    "model from {}: {}",
                    cloud.path, model.path,
                    n_points == 1 ? "its one point" : fmt::format("any of its {} points", n_points),
                    box_text(cloud.box), box_text(model.box), likely_cause(cloud, model)));
}

bool warn_of_lost(const std::string& cloud, const std::string& model, std::uint64_t lost,
                  std::uint64_t n, Reporter& reporter) {
    if (2 * lost <= n) return false;
    reporter.warn(fmt::format(
        "{}: {} of its {} points lie in no surfel's support of {}: are they in the same frame?",
        cloud, lost, n, model));
    return true;
}

}  // namespace slim
