#pragma once

#include "formats/image_io.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// A picture, read from its top, as planes of numbers by name: PNG as R G B A over 255,
/// EXR as stored.
class PictureRows {
public:
    /// throws as PngReader and ExrReader
    explicit PictureRows(const std::string& path);
    int width() const { return width_; }
    int height() const { return height_; }
    /// Channels in the order of their names.
    const std::vector<std::string>& names() const { return names_; }
    bool has(const std::string& name) const {
        return std::binary_search(names_.begin(), names_.end(), name);
    }

    void read(int n_rows);
    /// The channel in the rows read last.
    void plane(const std::string& name, std::vector<double>& out) const;

private:
    int width_ = 0, height_ = 0;
    std::vector<std::string> names_;
    std::optional<PngReader> png_;
    std::optional<ExrReader> exr_;
    std::vector<std::uint8_t> rgba_;
    std::map<std::string, ExrImage::Channel> channels_;
};

/// Two pictures of one size side by side, band by band: memory does not grow with them.
class PicturePair {
public:
    /// throws DataError if sizes differ or no channel is common
    PicturePair(const std::string& first, const std::string& second);
    const PictureRows& first() const { return a_; }
    const PictureRows& second() const { return b_; }
    const std::vector<std::string>& common() const { return common_; }

    /// Once: calls take(name, plane of the first, of the second) for each common channel of a band
    /// of whole rows, then band_done(first pixel, pixels), and so on to the last band.
    template <class Take, class Done>
    void for_each_band(const Take& take, const Done& band_done) {
        const auto width = static_cast<std::size_t>(a_.width());
        std::vector<double> of_a, of_b;
        for (int y = 0; y < a_.height(); y += rows_of_a_band()) {
            const int n = std::min(rows_of_a_band(), a_.height() - y);
            a_.read(n), b_.read(n);
            for (const std::string& name : common_) {
                a_.plane(name, of_a), b_.plane(name, of_b);
                take(name, of_a, of_b);
            }
            band_done(static_cast<std::size_t>(y) * width, static_cast<std::size_t>(n) * width);
        }
    }

private:
    /// About 262,144 pixels; whole blocks of an EXR.
    int rows_of_a_band() const { return std::max(1, (1 << 18) / a_.width() / 16) * 16; }

    PictureRows a_, b_;
    std::vector<std::string> common_;
};

}  // namespace slim
