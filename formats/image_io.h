#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// Text attributes of an image, by name. PNG: tEXt chunks (Software, Description, ...). EXR: string
/// attributes of the header. Numbers are written as text with all their digits: viewers agree on
/// strings only, and OpenImageIO drops doubles without a word (CONVENTIONS 4.2).
using ImageMetadata = std::map<std::string, std::string>;
/// A whole number, above 0: how large a picture is when printed; of PNG the chunk pHYs.
inline constexpr const char* kPixelsPerMetre = "PixelsPerMetre";

/// Matrices by name.
using ImageMatrices = std::map<std::string, std::array<float, 16>>;

/// Where an image lies in a larger one of that size; 0: it is the whole.
struct ImagePlace {
    int x = 0, y = 0, whole_width = 0, whole_height = 0;
};

enum class ChannelType { half_float, float32, uint32 };
/// The largest finite half: planes of halves are held at it.
inline constexpr float kLargestHalf = 65504;

/// One plane of an EXR, width * height values; floats for half_float and float32, integers for
/// uint32.
struct ExrChannel {
    std::string name;  ///< CONVENTIONS 1.1: "R", "Z", "N.X", "curvature.mean", "surfel.id", ...
    ChannelType type = ChannelType::float32;
    std::span<const float> floats{};
    std::span<const std::uint32_t> integers{};
};

/// Writes an 8-bit PNG marked sRGB, atomically (a temporary file in the same folder, then a
/// rename).
///
/// rgba    straight alpha, row-major from the top left; written as RGB if every alpha is 255
/// throws  IoError naming the file: exit 4 when it cannot be written
/// The same arguments give the same bytes: no time is written unless metadata brings a "DateTime".
void write_png_srgb8(const std::string& path, int width, int height,
                     std::span<const std::uint8_t> rgba, const ImageMetadata& metadata = {});

/// The same row by row from the top, for pictures larger than memory: RGBA in, written as RGB if
/// `opaque`.
class PngWriter {
public:
    PngWriter(const std::string& path, int width, int height, bool opaque,
              const ImageMetadata& metadata = {});
    ~PngWriter();
    PngWriter(PngWriter&&) noexcept;
    /// rgba: 4 width n values
    void add_rows(std::span<const std::uint8_t> rgba);
    /// After the last row: the file is whole, under its temporary name still (AtomicFile::seal).
    void seal();
    /// After the last row: the file appears under its name.
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes a single-part scanline EXR, zip compressed, with the chromaticities of Rec.709,
/// atomically.
///
/// channels  any order, unique names; R G B A are premultiplied linear colour
/// place     where the channels lie in a larger picture, as the data window of its display window
/// metadata  string attributes; "DateTime" becomes capDate, "ImageDescription" comments,
///           "Copyright" owner
/// matrices  m44f attributes such as worldToCamera: 16 floats, row-vector form as Imath has it,
///           that is with the translation in the last row
/// throws    IoError naming the file; a plane of the wrong length is a SLIM_CHECK failure
void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ImageMetadata& metadata = {}, const ImageMatrices& matrices = {},
               const ImagePlace& place = {});

/// The same band by band from the top, for pictures larger than memory.
class ExrWriter {
public:
    /// channels: names and types; their planes are not looked at
    ExrWriter(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
              const ImageMetadata& metadata = {}, const ImageMatrices& matrices = {},
              const ImagePlace& place = {});
    ~ExrWriter();
    ExrWriter(ExrWriter&&) noexcept;
    /// The same channels with their planes of the next n_rows rows.
    void add_rows(int n_rows, std::span<const ExrChannel> channels);
    /// Values of half planes that were beyond kLargestHalf and are written as that.
    std::uint64_t n_clamped() const;
    void seal();
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A picture of light: linear Rec.709, rows from the top, 3 floats a pixel.
struct LightImage {
    int width = 0, height = 0;
    std::vector<float> rgb;
};
/// Reads any format that OpenImageIO knows (EXR, HDR, PNG, JPEG, TIFF, ...): integers through the
/// sRGB curve, floats as they are; alpha is ignored, grey is widened, negative and not finite
/// values become 0.
/// throws IoError if there is no such file, FormatError naming it if it is no picture, is damaged,
/// or has more than 268 million pixels
LightImage read_light_image(const std::string& path);

/// A PNG as read back: always RGBA (alpha 255 if the file has none), straight alpha.
struct PngImage {
    int width = 0, height = 0, n_file_channels = 0;
    std::vector<std::uint8_t> rgba;
    ImageMetadata metadata;
    bool is_srgb = false;  ///< marked so
};
/// throws IoError if there is no such file, FormatError if it is no PNG or is damaged
PngImage read_png(const std::string& path);

/// The same row by row from the top, for pictures larger than memory.
class PngReader {
public:
    /// throws as read_png
    explicit PngReader(const std::string& path);
    ~PngReader();
    PngReader(PngReader&&) noexcept;
    /// All but the pixels.
    const PngImage& header() const;
    /// The next n_rows rows as RGBA: 4 width n_rows values. throws FormatError
    void read_rows(int n_rows, std::vector<std::uint8_t>& rgba);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// An EXR as read back: each channel in its own type.
struct ExrImage {
    struct Channel {
        ChannelType type = ChannelType::float32;
        std::vector<float> floats;  ///< half_float and float32
        std::vector<std::uint32_t> integers;
    };
    int width = 0, height = 0;
    std::map<std::string, Channel> channels;
    ImageMetadata metadata;
    ImageMatrices matrices;
    bool has_chromaticities = false, zip = false;
};
/// throws IoError if it cannot be opened, FormatError if it is not an EXR or is damaged
ExrImage read_exr(const std::string& path);

/// The same band by band from the top, for pictures larger than memory. Rows lie in blocks of up to
/// 16 in the file: bands of a multiple of that unpack each once.
class ExrReader {
public:
    /// throws as read_exr
    explicit ExrReader(const std::string& path);
    ~ExrReader();
    ExrReader(ExrReader&&) noexcept;
    /// What the header says; its channels have their type and no values.
    const ExrImage& header() const;
    /// The next n_rows rows: sets the values of `channels`, to which others of the file are added.
    /// throws FormatError
    void read_rows(int n_rows, std::map<std::string, ExrImage::Channel>& channels);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace slim
