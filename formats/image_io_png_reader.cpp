// PNG through libpng, as image_io_png_writer.cpp.

#include "formats/image_io.h"
#include "formats/png_failure.h"
#include "formats/png_names.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <png.h>

namespace slim {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 33;

}  // namespace

struct PngReader::State {
    struct Close {
        void operator()(std::FILE* f) const { std::fclose(f); }
    };
    std::string path;
    std::unique_ptr<std::FILE, Close> file;
    PngFailure failure;
    png_structp png = nullptr;
    png_infop info = nullptr;
    PngImage header;
    int next_row = 0;
    std::vector<std::uint8_t> whole;  ///< of an interlaced file, whose rows come in seven passes

    explicit State(const std::string& its_path) : path(its_path) {
        if (!std::filesystem::exists(path))
            throw IoError({.file = path, .problem = "no such file"});
        file.reset(std::fopen(path.c_str(), "rb"));
        if (!file) throw IoError({.file = path, .problem = "cannot be opened"});
        std::array<png_byte, 8> begin{};
        const std::size_t n = std::fread(begin.data(), 1, begin.size(), file.get());
        if (n < begin.size() || png_sig_cmp(begin.data(), 0, begin.size()) != 0)
            throw FormatError(path + ": expected a PNG, found another kind of file");
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, PngFailure::leave,
                                     PngFailure::ignore);
        if (png) info = png_create_info_struct(png);
        if (!info) throw IoError(path + ": cannot begin to read", ExitCode::resource);
        png_init_io(png, file.get());
        png_set_sig_bytes(png, static_cast<int>(begin.size()));
    }
    ~State() { png_destroy_read_struct(&png, &info, nullptr); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    template <class Body>
    void guarded(const Body& body) {
        if (!without_failure(failure, body))
            throw FormatError(path + ": damaged PNG: " + failure.words);
    }
    void begin();
    void read_texts();
    void read_whole();
};

/// Any PNG as RGBA of 8 bits: palettes, grey and 16 bits are turned into it by libpng.
void PngReader::State::begin() {
    guarded([&] { png_read_info(png, info); });
    const png_uint_32 width = png_get_image_width(png, info),
                      height = png_get_image_height(png, info);
    if (std::uint64_t{width} * height > kMostPixels)
        throw FormatError(path + ": expected at most 8 thousand million pixels, found " +
                          std::to_string(width) + "x" + std::to_string(height));
    header.width = static_cast<int>(width);
    header.height = static_cast<int>(height);
    header.n_file_channels = png_get_channels(png, info);
    guarded([&] {
        png_set_expand(png);
        png_set_scale_16(png);
        png_set_gray_to_rgb(png);
        png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
    });
    read_texts();
    if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE) read_whole();
}

void PngReader::State::read_texts() {
    png_textp texts = nullptr;
    const int n = png_get_text(png, info, &texts, nullptr);
    for (int i = 0; i < n; ++i)
        header.metadata[name_from_png(texts[i].key)] = texts[i].text ? texts[i].text : "";
    int intent = 0;
    if (png_get_sRGB(png, info, &intent)) header.is_srgb = true;
    if (const png_uint_32 per_metre = png_get_pixels_per_meter(png, info); per_metre > 0)
        header.metadata[kPixelsPerMetre] = std::to_string(per_metre);
    png_timep time = nullptr;
    if (!png_get_tIME(png, info, &time)) return;
    std::array<char, 40> words{};
    std::snprintf(words.data(), words.size(), "%04u:%02u:%02u %02u:%02u:%02u", unsigned{time->year},
                  unsigned{time->month}, unsigned{time->day}, unsigned{time->hour},
                  unsigned{time->minute}, unsigned{time->second});
    header.metadata["DateTime"] = words.data();
}

void PngReader::State::read_whole() {
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(header.width);
    whole.resize(row_bytes * static_cast<std::size_t>(header.height));
    std::vector<png_bytep> rows;
    for (int y = 0; y < header.height; ++y)
        rows.push_back(&whole[static_cast<std::size_t>(y) * row_bytes]);
    guarded([&] { png_read_image(png, rows.data()); });
}

PngReader::PngReader(const std::string& path) : state_(std::make_unique<State>(path)) {
    state_->begin();
}
PngReader::~PngReader() = default;
PngReader::PngReader(PngReader&&) noexcept = default;

const PngImage& PngReader::header() const { return state_->header; }

void PngReader::read_rows(int n_rows, std::vector<std::uint8_t>& rgba) {
    State& s = *state_;
    SLIM_CHECK(s.next_row + n_rows, <=, s.header.height);
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(s.header.width);
    rgba.resize(row_bytes * static_cast<std::size_t>(n_rows));
    if (!s.whole.empty())
        std::copy_n(&s.whole[static_cast<std::size_t>(s.next_row) * row_bytes], rgba.size(),
                    rgba.data());
    else
        s.guarded([&] {
            for (std::size_t at = 0; at < rgba.size(); at += row_bytes)
                png_read_row(s.png, &rgba[at], nullptr);
        });
    s.next_row += n_rows;
}

PngImage read_png(const std::string& path) {
    PngReader reader(path);
    PngImage image = reader.header();
    reader.read_rows(image.height, image.rgba);
    return image;
}

}  // namespace slim
