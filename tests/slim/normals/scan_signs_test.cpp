#include "slim/normals/scan_signs.h"

#include "tests/slim/fit/fit_support.h"
#include "tests/slim/normals/normals_support.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace slim::test {
namespace {

/// A sphere that three scans share, those of `inwards` turned round.
class ScanSigns : public ::testing::Test {
protected:
    void make(const std::vector<bool>& inwards) {
        block_ = along_curve(block_of(sampled("sphere", 6000)));
        block_.scan.resize(block_.size());
        for (std::size_t i = 0; i < block_.size(); ++i) {
            block_.scan[i] = static_cast<std::uint16_t>(block_.id[i] % inwards.size());
            if (inwards[block_.scan[i]]) block_.normal[i] = -block_.normal[i];
        }
    }
    std::vector<bool> contrary(std::span<const std::int64_t> facing = {}) const {
        std::vector<std::uint32_t> all(block_.size());
        std::iota(all.begin(), all.end(), 0u);
        return contrary_scans(block_, NearestSearch(block_.position), all, facing);
    }

    PointBlock block_;
};

using Scans = std::vector<bool>;

TEST_F(ScanSigns, TheSideOfFewerPointsIsContrary) {
    make({false, true, false});
    EXPECT_EQ(contrary(), (Scans{false, true, false}));
    make({true, false, true});
    EXPECT_EQ(contrary(), (Scans{false, true, false}));
}

TEST_F(ScanSigns, ScansThatAgreeAreNot) {
    make({true, true, true});
    EXPECT_EQ(contrary(), (Scans{false, false, false}));
}

TEST_F(ScanSigns, SensorsSayWhichSideIsRight) {
    make({true, false, true});
    const std::vector<std::int64_t> all_known{-300, 300, -300}, one_known{0, 300};
    EXPECT_EQ(contrary(all_known), (Scans{true, false, true}));
    EXPECT_EQ(contrary(one_known), (Scans{true, false, true}));
}

}  // namespace
}  // namespace slim::test
