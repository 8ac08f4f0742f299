#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// Whether a name is that of a picture that is read: .png or .exr, in any case.
bool is_picture(const std::string& path);

/// Compares two pictures of one size, pixel by pixel, channel by channel: PNG as stored, over 255,
/// EXR as stored (identifiers as numbers). A PNG and an EXR have no channel in common that means
/// the same: ConfigError.
///
/// threshold   a pixel differs where a channel differs by more
/// difference  PNG to write, empty: none: black where the pictures agree, else the pixel's greatest
///             difference, white at the greatest of all; red where only one of them has a finite
///             value
/// returns     width, height, pixels, channels (in both) with max, rms and above (share of the
///             pixels) of each, the same over all channels, max_at (x, y), mean, identical (with
///             the same channels), not_finite (values finite in one alone), only_in_first,
///             only_in_second (channels), difference_white
/// cost        bands of 262,144 pixels, one after the other: memory does not grow with the
///             pictures; a difference takes a second pass
/// throws      DataError if sizes differ or no channel is common; as read_png and read_exr
nlohmann::json compare_pictures(const std::string& first, const std::string& second,
                                const std::string& difference, double threshold);

}  // namespace slim
