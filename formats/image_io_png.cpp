// PNG through libpng: OpenImageIO, which can do it as well, brings 250 libraries whose loading
// takes longer than a picture (formats/notes/0003).

#include "formats/atomic_file.h"
#include "formats/image_io.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <png.h>

namespace slim {
namespace {

constexpr int kCompression = 4;           // of zlib: a third of the time of 6, 7 % more bytes
constexpr std::size_t kLongestName = 79;  // of a text, by the format
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 33;

bool is_opaque(std::span<const std::uint8_t> rgba) {
    for (std::size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] != 255) return false;
    return true;
}

/// Names that other programs write texts of a picture under, and ours, those of EXR.
constexpr std::array<std::pair<const char*, const char*>, 3> kNames{
    {{"Author", "Artist"}, {"Description", "ImageDescription"}, {"Title", "DocumentName"}}};

std::string name_in_png(const std::string& ours) {
    for (const auto& [png, name] : kNames)
        if (ours == name) return png;
    return ours.substr(0, kLongestName);
}
std::string name_from_png(const std::string& theirs) {
    for (const auto& [png, name] : kNames)
        if (theirs == png) return name;
    return theirs;
}

/// What libpng, which is C, is to throw once it has returned: its own words, or what our stream
/// threw.
struct PngFailure {
    std::jmp_buf out;
    std::string words;
    std::exception_ptr thrown;

    [[noreturn]] static void leave(png_structp png, png_const_charp words) {
        auto& failure = *static_cast<PngFailure*>(png_get_error_ptr(png));
        failure.words = words;
        std::longjmp(failure.out, 1);
    }
    static void ignore(png_structp, png_const_charp) {}
};

/// Calls of libpng only: no object of the body may need its destructor. Returns false after a
/// failure.
template <class Body>
bool without_failure(PngFailure& failure, const Body& body) {
    if (setjmp(failure.out)) return false;
    body();
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
    for (const auto& [name, value] : metadata) {
        if (name == "DateTime" && time_of(value, time))
            has_time = true;
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
        if (!std::filesystem::exists(path)) throw IoError(path + ": no such file");
        file.reset(std::fopen(path.c_str(), "rb"));
        if (!file) throw IoError(path + ": cannot be opened");
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
