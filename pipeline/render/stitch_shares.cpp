#include "pipeline/render/stitch_shares.h"

#include "formats/atomic_file.h"
#include "formats/image_io.h"
#include "pipeline/render/join_shares.h"
#include "pipeline/render/render_files.h"
#include "pipeline/render/render_view.h"
#include "pipeline/render/render_write.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// At once: a multiple of the blocks that EXR files pack.
constexpr int kRows = 64;

/// The tiles of one file, from the top.
struct Tiles {
    std::vector<fs::path> files;
    PictureSize size;  ///< of the whole

    int height_of(std::size_t i) const {
        const RenderShare share{static_cast<int>(i) + 1, static_cast<int>(files.size())};
        return share_end(size.height, share) - share_begin(size.height, share);
    }
    void require_size(std::size_t i, int width, int height) const {
        if (width != size.width || height != height_of(i))
            throw FormatError(fmt::format("{}: expected {}x{} pixels, found {}x{}",
                                          files[i].string(), size.width, height_of(i), width,
                                          height));
    }
};

void stitch_png(const Tiles& tiles, bool has_background, bool at_once, const fs::path& whole) {
    // As one run decides: without alpha if nothing shows behind, or if that is seen of the whole at
    // once.
    bool opaque = has_background || at_once;
    for (const fs::path& file : tiles.files)
        opaque = opaque && PngReader(file.string()).header().n_file_channels == 3;
    PngWriter out(whole.string(), tiles.size.width, tiles.size.height, opaque,
                  PngReader(tiles.files[0].string()).header().metadata);
    std::vector<std::uint8_t> rows;
    for (std::size_t i = 0; i < tiles.files.size(); ++i) {
        PngReader in(tiles.files[i].string());
        tiles.require_size(i, in.header().width, in.header().height);
        for (int y = 0; y < in.header().height; y += kRows) {
            in.read_rows(std::min(kRows, in.header().height - y), rows);
            out.add_rows(rows);
        }
    }
    out.commit();
}

std::vector<ExrChannel> channels_of_rows(const std::map<std::string, ExrImage::Channel>& rows) {
    std::vector<ExrChannel> channels;
    for (const auto& [name, channel] : rows)
        channels.push_back({name, channel.type, channel.floats, channel.integers});
    return channels;
}

void stitch_exr(const Tiles& tiles, const fs::path& whole) {
    const ExrReader first(tiles.files[0].string());
    std::map<std::string, ExrImage::Channel> rows = first.header().channels;
    ExrWriter out(whole.string(), tiles.size.width, tiles.size.height, channels_of_rows(rows),
                  first.header().metadata, first.header().matrices);
    for (std::size_t i = 0; i < tiles.files.size(); ++i) {
        ExrReader in(tiles.files[i].string());
        tiles.require_size(i, in.header().width, in.header().height);
        for (int y = 0; y < in.header().height; y += kRows) {
            const int n = std::min(kRows, in.header().height - y);
            in.read_rows(n, rows);
            out.add_rows(n, channels_of_rows(rows));
        }
    }
    out.commit();
}

void copy_whole(const fs::path& from, const fs::path& to) {
    std::ifstream in(from, std::ios::binary);
    if (!in) throw IoError(from.string() + ": cannot be opened");
    write_file_atomically(to.string(), std::string(std::istreambuf_iterator<char>(in), {}));
}

}  // namespace

std::vector<fs::path> stitch_shares(const RenderConfig& config,
                                    const std::vector<std::string>& aovs,
                                    const std::set<fs::path>& written, bool at_once,
                                    StageContext& context) {
    const OutputPlan whole = plan_outputs(config, aovs);
    std::vector<OutputPlan> shares;
    for (int i = 1; i <= config.join; ++i)
        shares.push_back(plan_outputs(config_of_share(config, {i, config.join}), aovs));
    const auto tiles = [&](const auto& file_of) {
        Tiles of{{}, parse_size(config.size)};
        for (const OutputPlan& share : shares) of.files.push_back(file_of(share));
        return of;
    };
    std::vector<fs::path> files;
    // What is not of rows the first share has written for the whole.
    const RenderConfig first = config_of_share(config, {1, config.join});
    const auto copy = [&](const fs::path& from, const fs::path& to) {
        if (!written.contains(from.filename())) return;
        copy_whole(from, to);
        files.push_back(to);
    };
    make_folder(whole);
    copy(shares[0].lines_svg(), whole.lines_svg());
    copy(shares[0].contours_svg(), whole.contours_svg());
    copy(first.lines_ply, config.lines_ply);
    copy(first.lines_obj, config.lines_obj);
    for (std::size_t k = 0; k < whole.pngs.size(); ++k) {
        context.reporter.progress("pictures", k, whole.pngs.size());
        stitch_png(tiles([&](const OutputPlan& share) { return share.pngs[k]; }),
                   has_background(config, whole.drawn[k]), at_once, whole.pngs[k]);
        files.push_back(whole.pngs[k]);
    }
    if (!whole.exr.empty()) {
        stitch_exr(tiles([](const OutputPlan& share) { return share.exr; }), whole.exr);
        files.push_back(whole.exr);
    }
    for (const std::string& aov : whole.drawn) copy(shares[0].legend(aov), whole.legend(aov));
    return files;
}

}  // namespace slim
