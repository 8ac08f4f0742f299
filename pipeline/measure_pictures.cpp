#include "pipeline/measure_pictures.h"

#include "formats/extension.h"
#include "formats/image_io.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

/// A picture as planes of numbers by name.
struct Planes {
    int width = 0, height = 0;
    std::map<std::string, std::vector<double>> channel;
};

Planes planes_of_png(const std::string& path) {
    const PngImage image = read_png(path);
    Planes out{image.width, image.height, {}};
    const char* names[] = {"R", "G", "B", "A"};
    for (std::size_t c = 0; c < 4; ++c) {
        std::vector<double>& plane = out.channel[names[c]];
        for (std::size_t i = c; i < image.rgba.size(); i += 4) plane.push_back(image.rgba[i] / 255.0);
    }
    return out;
}

Planes planes_of(const std::string& path) {
    if (lower_extension(path) == ".png") return planes_of_png(path);
    const ExrImage image = read_exr(path);
    Planes out{image.width, image.height, {}};
    for (const auto& [name, channel] : image.channels) {
        std::vector<double>& plane = out.channel[name];
        plane.assign(channel.floats.begin(), channel.floats.end());
        if (channel.type == ChannelType::uint32)
            plane.assign(channel.integers.begin(), channel.integers.end());
    }
    return out;
}

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

/// Adds one channel; `worst` keeps the greatest difference of every pixel.
Differences compare(const std::vector<double>& a, const std::vector<double>& b, double threshold,
                    std::vector<double>& worst) {
    Differences out;
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
    return out;
}

/// Grey by the square root of the share of `white`: small differences show.
void draw(const std::string& path, const Planes& size, const std::vector<double>& worst,
          double white) {
    std::vector<std::uint8_t> rgba;
    rgba.reserve(4 * worst.size());
    for (const double d : worst) {
        const double share = white > 0 && std::isfinite(d) ? std::sqrt(d / white) : 0;
        const auto grey = static_cast<std::uint8_t>(std::lround(255 * share));
        const bool lone = std::isinf(d);
        for (const std::uint8_t c : {lone ? std::uint8_t{255} : grey, grey, grey, std::uint8_t{255}})
            rgba.push_back(c);
    }
    write_png_srgb8(path, size.width, size.height, rgba,
                    {{"Description", fmt::format("difference of two pictures; white: {}, grey: "
                                                 "square root of the share", white)}});
}

void check_sizes(const std::string& first, const Planes& a, const std::string& second,
                 const Planes& b) {
    if (a.width != b.width || a.height != b.height)
        throw DataError(fmt::format("{} has {}x{} pixels, {} {}x{}: expected two pictures of one size",
                                    first, a.width, a.height, second, b.width, b.height));
}

json names_missing(const Planes& in, const Planes& from) {
    json names = json::array();
    for (const auto& [name, plane] : in.channel)
        if (!from.channel.contains(name)) names.push_back(name);
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
        throw ConfigError(fmt::format("{} and {}: expected two PNG or two EXR: their numbers do not "
                                      "mean the same", first, second));
    if (!difference.empty() && lower_extension(difference) != ".png")
        throw ConfigError(difference + ": the difference is a PNG; expected a name ending in .png");
    const Planes a = planes_of(first), b = planes_of(second);
    check_sizes(first, a, second, b);
    std::vector<double> worst(static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height));
    const auto pixels = static_cast<double>(worst.size());
    Differences all;
    json channels = json::object();
    for (const auto& [name, plane] : a.channel) {
        if (!b.channel.contains(name)) continue;
        const Differences d = compare(plane, b.channel.at(name), threshold, worst);
        channels[name] = d.to_json(pixels);
        all.n += d.n, all.sum += d.sum, all.squares += d.squares, all.not_finite += d.not_finite;
        all.max = std::max(all.max, d.max);
    }
    if (channels.empty())
        throw DataError(fmt::format("{} and {} have no channel in common", first, second));
    std::size_t at = 0;
    for (std::size_t i = 0; i < worst.size(); ++i) {
        all.above += worst[i] > threshold ? 1 : 0;
        if (worst[i] > worst[at]) at = i;
    }
    json out = all.to_json(pixels);
    const json only_a = names_missing(a, b), only_b = names_missing(b, a);
    const auto width = static_cast<std::size_t>(a.width);
    out.update({{"width", a.width},
                {"height", a.height},
                {"pixels", worst.size()},
                {"threshold", threshold},
                {"max_at", {at % width, at / width}},
                {"identical", all.max == 0 && all.not_finite == 0 && only_a.empty() && only_b.empty()},
                {"channels", std::move(channels)},
                {"only_in_first", only_a},
                {"only_in_second", only_b}});
    if (difference.empty()) return out;
    draw(difference, a, worst, all.max);
    out["difference"] = difference, out["difference_white"] = all.max;
    return out;
}

}  // namespace slim
