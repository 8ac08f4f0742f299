#include "pipeline/render/render_share.h"

#include "pipeline/render/render_cameras.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <charconv>
#include <string>
#include <utility>

namespace slim {
namespace {

/// ConfigError for what has no sense beside shares.
void require_whole(const RenderConfig& config, const char* key) {
    const std::pair<const char*, bool> others[] = {
        {"crop", !config.crop.empty()},
        {"tile", !config.tile.empty()},
        {"frame", config.frame > 0},
        {"repeat", config.repeat > 1},
        {"share and join", !config.share.empty() && config.join > 0}};
    for (const auto& [other, given] : others)
        if (given)
            throw ConfigError({.key = key,
                               .problem = std::string("shares are of the whole: ") +
                                          (other == std::string("share and join")
                                               ? "give share or join, not both"
                                               : fmt::format("leave out {}", other))});
}

/// As many shares as there are pictures of a film, rows of a picture.
void require_enough(const RenderConfig& config, const char* key, int n) {
    const int most = is_film(config) ? n_frames(config) : parse_size(config.size).height;
    if (n > most)
        throw ConfigError({.key = key,
                           .expected = fmt::format("at most {} shares, one for each {}", most,
                                                   is_film(config) ? "picture" : "row"),
                           .found = std::to_string(n)});
}

int whole_number(const std::string& text) {
    int value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && rest == text.data() + text.size() ? value : 0;
}

}  // namespace

bool is_film(const RenderConfig& config) { return config.turntable > 0 || !config.path.empty(); }

RenderShare share_of(const RenderConfig& config) {
    if (config.share.empty()) return {};
    require_whole(config, "share");
    const std::size_t slash = config.share.find('/');
    RenderShare share;
    if (slash != std::string::npos)
        share = {whole_number(config.share.substr(0, slash)),
                 whole_number(config.share.substr(slash + 1))};
    if (share.number < 1 || share.number > share.of)
        throw ConfigError({.key = "share",
                           .expected = "i/n with i from 1 to n",
                           .found = "'" + config.share + "'"});
    require_enough(config, "share", share.of);
    return share;
}

void check_join(const RenderConfig& config) {
    require_whole(config, "join");
    require_enough(config, "join", config.join);
}

int share_begin(int n, const RenderShare& share) {
    return static_cast<int>(static_cast<long long>(n) * (share.number - 1) / share.of);
}

int share_end(int n, const RenderShare& share) {
    return static_cast<int>(static_cast<long long>(n) * share.number / share.of);
}

FrameRange wanted_frames(const RenderConfig& config, const RenderShare& share) {
    const int n = n_frames(config);
    if (config.frame > 0) return {config.frame, config.frame};
    if (share.of == 0 || n == 1) return {1, n};
    return {share_begin(n, share) + 1, share_end(n, share)};
}

std::filesystem::path share_folder(const std::filesystem::path& named, const RenderShare& share) {
    return std::filesystem::path(named.string() + ".shares") /
           fmt::format("{:04}_of_{:04}", share.number, share.of);
}

std::filesystem::path share_target(const std::filesystem::path& named, const RenderShare& share) {
    return share_folder(named, share).string() + ".done.json";
}

}  // namespace slim
