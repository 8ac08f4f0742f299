#include "formats/fit_file.h"

#include "tests/formats/file_support.h"

#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace slim::test {
namespace {

TEST(FitFile, RoundTripsAndSeesDamage) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4)};
    write_fit(folder.file("f"), surfels, "{\"lambda\": 0.5}");
    const FitFile fit = read_fit(folder.file("f"));
    EXPECT_EQ(fit.header_json, "{\"lambda\": 0.5}");
    ASSERT_EQ(fit.surfels.size(), 2u);
    const FittedSurfel& back = fit.surfels[1];
    EXPECT_EQ(back.surfel.center, surfels[1].surfel.center);
    EXPECT_EQ(back.surfel.support_radius, 0.5);
    EXPECT_EQ(back.surfel.frame.normal, surfels[1].surfel.frame.normal);
    EXPECT_EQ(back.surfel.frame.u_axis, surfels[1].surfel.frame.u_axis);
    EXPECT_EQ(back.surfel.polynomial.a, surfels[1].surfel.polynomial.a);
    EXPECT_EQ(back.surfel.degree, 2);
    EXPECT_EQ(back.fit_error, 0.01);
    EXPECT_EQ(back.n_points, 55u);
    EXPECT_EQ(back.level, 3);
    EXPECT_EQ(back.flags, kLeaf);
    EXPECT_EQ(back.point_id, 123456789012345u);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

TEST(FitFile, RefusesNumbersThatAreNotFinite) {
    const TempFolder folder;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuses = [&](auto&& spoil) {
        FittedSurfel s = some_surfel(1);
        spoil(s);
        write_fit(folder.file("f"), std::vector<FittedSurfel>{s}, "{}");
        EXPECT_THROW(read_fit(folder.file("f")), FormatError);
    };
    refuses([&](FittedSurfel& s) { s.surfel.polynomial.a[3] = nan; });
    refuses([&](FittedSurfel& s) { s.surfel.frame.normal.z = nan; });
    refuses([&](FittedSurfel& s) { s.fit_error = nan; });
    refuses([&](FittedSurfel& s) { s.fit_error = -1; });
    refuses([&](FittedSurfel& s) {
        SharpSheets sheets;
        sheets.n_extra = 1;
        sheets.extra[0].polynomial.a[0] = nan;
        s.surfel.sharp = std::make_shared<const SharpSheets>(sheets);
    });
}

TEST(FitFile, KeepsEveryRim) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels;
    for (int k = 0; k < kRimDirections; ++k)
        for (int reach = 0; reach <= kRimReaches; ++reach) {
            surfels.push_back(some_surfel(static_cast<std::uint64_t>(k)));
            surfels.back().surfel.rims.first = pack_rim(k, reach > 0 ? kRimStep * reach - 0.01 : 1);
        }
    write_fit(folder.file("f"), surfels, "{}", {});
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 4);  // the version stands behind the magic
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), surfels.size());
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        EXPECT_EQ(fit.surfels[i].surfel.rims, surfels[i].surfel.rims);
        EXPECT_EQ(fit.surfels[i].surfel.degree, surfels[i].surfel.degree);
    }
}

TEST(FitFile, KeepsSecondRimsAndMakesItVersion5) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    surfels[1].surfel.rims = {pack_rim(3, 0.2), pack_rim(30, 0.5)};
    surfels[2].surfel.rims = {pack_rim(9, 0.2), 0};
    write_fit(folder.file("f"), surfels, "{}", {});
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 5);
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(fit.surfels[i].surfel.rims, surfels[i].surfel.rims);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
    surfels[0].surfel.rims.second = pack_rim(1, 0.1);
    write_fit(folder.file("f"), surfels, "{}", {});
    EXPECT_NE(error_of([&] { read_fit(folder.file("f")); }).find("has a second rim and no first"),
              std::string::npos);
}

TEST(FitFile, KeepsDroppedPointsAndReadsWhatIsWanted) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    const std::vector<std::uint64_t> dropped{3, 1, std::uint64_t{1} << 40};
    write_fit(folder.file("f"), surfels, "{}", dropped);
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 3);  // the version stands behind the magic
    const FitFile fit = read_fit(folder.file("f"), [&](const FittedSurfel& s) {
        return s.surfel.center == surfels[1].surfel.center;
    });
    EXPECT_EQ(fit.dropped, dropped);
    ASSERT_EQ(fit.surfels.size(), 1u);
    EXPECT_EQ(fit.surfels[0].surfel.center, surfels[1].surfel.center);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

TEST(FitReader, HandsOutTheSameSurfelsEveryTimeEvenIfAnotherFileTakesTheName) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    write_fit(folder.file("f"), surfels, "{\"a\": 1}", std::vector<std::uint64_t>{9});
    const FitReader reader(folder.file("f"));
    write_fit(folder.file("f"), std::vector<FittedSurfel>{some_surfel(7)}, "{}");
    EXPECT_EQ(reader.n_surfels(), 3u);
    EXPECT_EQ(reader.header_json(), "{\"a\": 1}");
    EXPECT_EQ(reader.dropped(), std::vector<std::uint64_t>{9});
    for (int pass = 0; pass < 2; ++pass) {
        std::size_t next = 0;
        reader.for_each([&](const FittedSurfel& s) {
            ASSERT_LT(next, surfels.size());
            EXPECT_EQ(s.surfel.center, surfels[next++].surfel.center);
        });
        EXPECT_EQ(next, surfels.size());
    }
}

TEST(FitFile, SharpSurfelsRoundTripAndMakeItVersion2) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    write_fit(folder.file("smooth"), surfels, "{}");
    surfels[0].surfel.sharp = some_sheets(2);
    surfels[2].surfel.sharp = some_sheets(1);
    write_fit(folder.file("f"), surfels, "{}");
    // The version stands behind the magic.
    EXPECT_EQ(read_bytes(folder.file("smooth"))[8], 1);
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 2);
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), 3u);
    EXPECT_FALSE(fit.surfels[1].surfel.sharp);
    for (const std::size_t i : {0u, 2u}) {
        ASSERT_TRUE(fit.surfels[i].surfel.sharp);
        expect_equal(*fit.surfels[i].surfel.sharp, *surfels[i].surfel.sharp);
    }
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

TEST(FitFile, CornersOfManySheetsRoundTripAndMakeItVersion6) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels;
    for (std::size_t n_extra = 1; n_extra < kMostSheets; ++n_extra) {
        surfels.push_back(some_surfel(static_cast<double>(n_extra)));
        surfels.back().surfel.sharp = some_sheets(n_extra);
    }
    write_fit(folder.file("f"), surfels, "{}");
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 6);
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), surfels.size());
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        ASSERT_TRUE(fit.surfels[i].surfel.sharp);
        expect_equal(*fit.surfels[i].surfel.sharp, *surfels[i].surfel.sharp);
        EXPECT_FALSE(fit.surfels[i].surfel.rims.any());
    }
}

}  // namespace
}  // namespace slim::test
