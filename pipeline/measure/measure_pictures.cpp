#include "pipeline/measure/measure_pictures.h"

#include "formats/extension.h"
#include "formats/image_io.h"
#include "pipeline/measure/picture_pair.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

/// Differences of one channel, or of all.
struct Differences {
    double max = 0, sum = 0, squares = 0;
    std::size_t n = 0, above = 0, not_finite = 0;

    json to_json(double pixels) const {
        const double values = std::max<double>(1, static_cast<double>(n));
        return {{"max", max},
                {"mean", sum / values},
                {"rms", std::sqrt(squares / values)},
                {"above", static_cast<double>(above) / pixels},
                {"not_finite", not_finite}};
    }
};

/// |a - b|; 0 where both are NaN or the same infinity; infinite where one alone is not finite.
double difference_of(double a, double b) {
    if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
    const double d = std::abs(a - b);
    return std::isfinite(d) ? d : std::numeric_limits<double>::infinity();
}

/// Adds a band of one channel; `worst` keeps the greatest difference of every pixel of the band.
void compare(const std::vector<double>& a, const std::vector<double>& b, double threshold,
             std::vector<double>& worst, Differences& out) {
    worst.resize(a.size(), 0);
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = difference_of(a[i], b[i]);
        worst[i] = std::max(worst[i], d);
        out.above += d > threshold ? 1 : 0;
        if (std::isinf(d)) {
            ++out.not_finite;
            continue;
        }
        ++out.n, out.sum += d, out.squares += d * d, out.max = std::max(out.max, d);
    }
}

/// What the comparison of all bands came to.
struct Comparison {
    std::map<std::string, Differences> channels;
    Differences all;      ///< `above` counts pixels
    std::size_t at = 0;   ///< the first pixel of the greatest difference
    bool equal() const { return all.max == 0 && all.not_finite == 0; }
};

Comparison compared(PicturePair& pair, double threshold) {
    Comparison out;
    std::vector<double> worst;
    double greatest = 0;
    const auto take = [&](const std::string& name, const auto& a, const auto& b) {
        compare(a, b, threshold, worst, out.channels[name]);
    };
    pair.for_each_band(take, [&](std::size_t first, std::size_t n) {
        for (std::size_t i = 0; i < n; ++i) {
            out.all.above += worst[i] > threshold ? 1 : 0;
            if (worst[i] > greatest) greatest = worst[i], out.at = first + i;
        }
        worst.clear();
    });
    for (const auto& [name, d] : out.channels) {
        out.all.n += d.n, out.all.sum += d.sum, out.all.squares += d.squares,
            out.all.not_finite += d.not_finite;
        out.all.max = std::max(out.all.max, d.max);
    }
    return out;
}

std::string description_of(const Comparison& c) {
    if (c.equal()) return "no difference between two pictures: black";
    return fmt::format("difference of two pictures; white: {}, grey: square root of the share",
                       c.all.max);
}

/// Grey by the square root of the share of the greatest:
/// small differences show. Reads both once more.
void draw(const std::string& path, PicturePair& pair, const Comparison& known) {
    PngWriter file(path, pair.first().width(), pair.first().height(), true,
                   {{"Description", description_of(known)}});
    const double white = known.all.max;
    std::vector<double> worst;
    std::vector<std::uint8_t> rgba;
    Differences again;
    const auto take = [&](const std::string&, const auto& a, const auto& b) {
        compare(a, b, 0, worst, again);
    };
    pair.for_each_band(take, [&](std::size_t, std::size_t) {
        rgba.clear();
        for (const double d : worst) {
            const double share = white > 0 && std::isfinite(d) ? std::sqrt(d / white) : 0;
            const auto grey = static_cast<std::uint8_t>(std::lround(255 * share));
            const bool lone = std::isinf(d);
            for (const std::uint8_t c :
                 {lone ? std::uint8_t{255} : grey, grey, grey, std::uint8_t{255}})
                rgba.push_back(c);
        }
        file.add_rows(rgba);
        worst.clear();
    });
    file.commit();
}

json names_missing(const PictureRows& in, const PictureRows& from) {
    json names = json::array();
    for (const std::string& name : in.names())
        if (!from.has(name)) names.push_back(name);
    return names;
}

}  // namespace

bool is_picture(const std::string& path) {
    const std::string extension = lower_extension(path);
    return extension == ".png" || extension == ".exr";
}

json compare_pictures(const std::string& first, const std::string& second,
                      const std::string& difference, double threshold) {
    if (lower_extension(first) != lower_extension(second))
        throw ConfigError(
            fmt::format("{} and {}: expected two PNG or two EXR: their numbers do not mean the "
                        "same",
                        first, second));
    if (!difference.empty() && lower_extension(difference) != ".png")
        throw ConfigError({.file = difference,
                           .problem = "the difference is a PNG",
                           .expected = "a name ending in .png"});
    PicturePair pair(first, second);
    const Comparison c = compared(pair, threshold);
    const auto width = static_cast<std::size_t>(pair.first().width());
    const std::size_t pixels = width * static_cast<std::size_t>(pair.first().height());
    json channels = json::object();
    for (const auto& [name, d] : c.channels)
        channels[name] = d.to_json(static_cast<double>(pixels));
    json out = c.all.to_json(static_cast<double>(pixels));
    const json only_a = names_missing(pair.first(), pair.second()),
               only_b = names_missing(pair.second(), pair.first());
    out.update({{"width", pair.first().width()},
                {"height", pair.first().height()},
                {"pixels", pixels},
                {"threshold", threshold},
                {"max_at", {c.at % width, c.at / width}},
                {"identical", c.equal() && only_a.empty() && only_b.empty()},
                {"channels", std::move(channels)},
                {"only_in_first", only_a},
                {"only_in_second", only_b}});
    if (difference.empty()) return out;
    PicturePair again(first, second);
    draw(difference, again, c);
    out["difference"] = difference, out["difference_white"] = c.all.max;
    return out;
}

}  // namespace slim
