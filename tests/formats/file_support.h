#pragma once

#include "slim/model/fitted_surfel.h"
#include "slim/model/sharp_sheets.h"
#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"
#include "tests/formats/format_support.h"

#include <functional>
#include <memory>
#include <string>

namespace slim::test {

inline std::string error_of(const std::function<void()>& action) {
    try {
        action();
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

/// read() must refuse the file with any one byte changed and with any number of bytes missing.
inline void expect_every_damage_is_seen(const TempFolder& folder, const std::string& bytes,
                                 const std::function<void(const std::string&)>& read) {
    ASSERT_EQ(error_of([&] { read(folder.write("sound", bytes)); }), "");
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        const std::string path = folder.write("damaged", damaged);
        const std::string error = error_of([&] { read(path); });
        ASSERT_EQ(error.find(path + ": byte "), 0u) << "byte " << i << ": " << error;
    }
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        const std::string path = folder.write("cut", bytes.substr(0, n));
        ASSERT_EQ(error_of([&] { read(path); }).find(path), 0u) << n;
    }
    EXPECT_NE(error_of([&] { read(folder.write("long", bytes + '\0')); }), "");
}

inline FittedSurfel some_surfel(double x) {
    Surfel surfel{{x, 1, 2}, 0.5, frame_from_normal(round_normal(Vec3d{0, 0.6, 0.8})), {}, 2};
    surfel.polynomial.a = {0.1, 0, 0, 0.25, -0.5, 0.75};
    FittedSurfel fitted{surfel};
    fitted.fit_error = 0.01;
    fitted.n_points = 55;
    fitted.level = 3;
    fitted.flags = kLeaf;
    fitted.point_id = 123456789012345;
    return fitted;
}

/// Two further sheets, joined unlike.
inline std::shared_ptr<const SharpSheets> some_sheets(std::size_t n_extra) {
    auto out = std::make_shared<SharpSheets>();
    out->n_extra = n_extra;
    out->outer = Join::min;
    for (std::size_t k = 0; k < n_extra; ++k) {
        out->extra[k].frame = frame_from_normal(round_normal(
            normalized(Vec3d{1, 0.5 * static_cast<double>(k), -0.25})));
        for (std::size_t i = 0; i < 6; ++i)
            out->extra[k].polynomial.a[i] = 0.125 * static_cast<double>(i + k);
    }
    return out;
}

inline void expect_equal(const SharpSheets& a, const SharpSheets& b) {
    ASSERT_EQ(a.n_extra, b.n_extra);
    EXPECT_EQ(a.outer, b.outer);
    EXPECT_EQ(a.inner, b.inner);
    for (std::size_t k = 0; k < a.n_extra; ++k) {
        EXPECT_EQ(a.extra[k].frame.normal, b.extra[k].frame.normal);
        EXPECT_EQ(a.extra[k].frame.u_axis, b.extra[k].frame.u_axis);
        EXPECT_EQ(a.extra[k].polynomial.a, b.extra[k].polynomial.a);
    }
}

}  // namespace slim::test
