// PNG through libpng: OpenImageIO, which can do it as well, brings 250 libraries whose loading
// takes longer than a picture (formats/notes/0002).

#include "formats/atomic_file.h"
#include "formats/image_io.h"
#include "formats/png_failure.h"
#include "formats/png_names.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <png.h>

namespace slim {
namespace {

constexpr int kCompression = 4;  // of zlib: a third of the time of 6, 7 % more bytes

bool is_opaque(std::span<const std::uint8_t> rgba) {
    for (std::size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] != 255) return false;
    return true;
}

/// Texts in the form of libpng: Latin-1 as tEXt would be, other words as UTF-8.
std::vector<png_text> texts_of(std::vector<std::pair<std::string, std::string>>& names_and_words) {
    std::vector<png_text> texts;
    for (auto& [name, words] : names_and_words) {
        const bool ascii =
            std::all_of(words.begin(), words.end(), [](char c) { return (c & 0x80) == 0; });
        png_text t{};
        t.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        t.key = name.data();
        t.text = words.data();
        t.text_length = ascii ? words.size() : 0;
        t.itxt_length = ascii ? 0 : words.size();
        texts.push_back(t);
    }
    return texts;
}

bool time_of(const std::string& words, png_time& time) {
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
    if (std::sscanf(words.c_str(), "%d:%d:%d %d:%d:%d", &year, &month, &day, &hour, &minute,
                    &second) != 6)
        return false;
    time = {static_cast<png_uint_16>(year), static_cast<png_byte>(month),
            static_cast<png_byte>(day),     static_cast<png_byte>(hour),
            static_cast<png_byte>(minute),  static_cast<png_byte>(second)};
    return true;
}

}  // namespace

struct PngWriter::State {
    int width = 0;
    bool opaque = false;
    bool ended = false;
    AtomicFile file;
    PngFailure failure;
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::vector<std::uint8_t> row;  ///< without alpha

    explicit State(const std::string& path) : file(path) {
        png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, PngFailure::leave,
                                      PngFailure::ignore);
        if (png) info = png_create_info_struct(png);
        if (!info) throw IoError(path + ": cannot begin a PNG", ExitCode::resource);
        png_set_write_fn(png, this, put, nullptr);
    }
    ~State() { png_destroy_write_struct(&png, &info); }

    static void put(png_structp png, png_bytep bytes, std::size_t n) {
        auto& state = *static_cast<State*>(png_get_io_ptr(png));
        try {
            state.file.write(bytes, n);
            return;
        } catch (...) {
            state.failure.thrown = std::current_exception();
        }
        png_error(png, "write error");
    }
    template <class Body>
    void guarded(const Body& body) {
        if (without_failure(failure, body)) return;
        if (failure.thrown) std::rethrow_exception(failure.thrown);
        throw IoError(file.path() + ": cannot encode PNG: " + failure.words, ExitCode::resource);
    }
    void begin(int height, const ImageMetadata& metadata);
};

void PngWriter::State::begin(int height, const ImageMetadata& metadata) {
    std::vector<std::pair<std::string, std::string>> words;
    png_time time{};
    bool has_time = false;
    png_uint_32 per_metre = 0;
    for (const auto& [name, value] : metadata) {
        if (name == "DateTime" && time_of(value, time))
            has_time = true;
        else if (name == kPixelsPerMetre)
            per_metre = static_cast<png_uint_32>(std::strtoul(value.c_str(), nullptr, 10));
        else
            words.emplace_back(name_in_png(name), value);
    }
    const std::vector<png_text> texts = texts_of(words);
    guarded([&] {
        png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                     8, opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
        if (has_time) png_set_tIME(png, info, &time);
        if (per_metre > 0)
            png_set_pHYs(png, info, per_metre, per_metre, PNG_RESOLUTION_METER);
        if (!texts.empty()) png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
        png_set_compression_level(png, kCompression);
        png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
        png_write_info(png, info);
    });
}

PngWriter::PngWriter(const std::string& path, int width, int height, bool opaque,
                     const ImageMetadata& metadata)
    : state_(std::make_unique<State>(path)) {
    state_->width = width, state_->opaque = opaque;
    state_->begin(height, metadata);
}

PngWriter::~PngWriter() = default;
PngWriter::PngWriter(PngWriter&&) noexcept = default;

void PngWriter::add_rows(std::span<const std::uint8_t> rgba) {
    State& s = *state_;
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(s.width);
    SLIM_CHECK(rgba.size() % row_bytes, ==, 0u);
    for (std::size_t at = 0; at < rgba.size(); at += row_bytes) {
        const std::uint8_t* row = &rgba[at];
        if (s.opaque) {
            s.row.resize(row_bytes / 4 * 3);
            for (std::size_t i = 0; i < row_bytes / 4; ++i)
                std::copy_n(row + 4 * i, 3, &s.row[3 * i]);
            row = s.row.data();
        }
        s.guarded([&] { png_write_row(s.png, row); });
    }
}

void PngWriter::seal() {
    State& s = *state_;
    s.guarded([&] { png_write_end(s.png, nullptr); });
    s.ended = true;
    s.file.seal();
}

void PngWriter::commit() {
    if (!state_->ended) seal();
    state_->file.commit();
}

void write_png_srgb8(const std::string& path, int width, int height,
                     std::span<const std::uint8_t> rgba, const ImageMetadata& metadata) {
    SLIM_CHECK(rgba.size(), ==,
               4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    PngWriter writer(path, width, height, is_opaque(rgba), metadata);
    writer.add_rows(rgba);
    writer.commit();
}

}  // namespace slim
