#include "formats/model_file.h"

#include "slim/model/surfel_encoder.h"
#include "tests/formats/file_support.h"

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace slim::test {
namespace {

/// A root with two leaves.
SurfelTreeData some_model() {
    SurfelTreeData data;
    data.header.degree = 2;
    data.header.origin = {1e6, 0, 0};
    data.header.bounds = {{0, 0, 0}, {4, 4, 4}};
    data.header.diagonal = 7;
    data.header.mdl_threshold = 0.01;
    data.header.n_points = 110;
    data.header.n_leaves = 2;
    std::vector<Surfel> surfels{some_surfel(2).surfel, some_surfel(1).surfel,
                                some_surfel(3).surfel};
    surfels[0].support_radius = 5;
    encode_surfels(surfels, data);
    data.nodes.resize(3);
    data.nodes[0].first_child = 1;
    data.nodes[0].n_children = 2;
    data.nodes[0].bound_radius = 5;
    for (std::size_t i = 1; i < 3; ++i) {
        data.nodes[i].bound_radius = 0.5f;
        data.nodes[i].level = 1;
        data.nodes[i].degree = 2;
        data.nodes[i].flags = kLeaf;
    }
    return data;
}

/// some_model with a sharp node 2.
SurfelTreeData some_sharp_model() {
    SurfelTreeData data = some_model();
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < data.nodes.size(); ++i) surfels.push_back(data.view().surfel(i));
    surfels[2].sharp = some_sheets(2);
    encode_surfels(surfels, data);
    data.nodes[2].flags |= kSharp;
    return data;
}

TEST(ModelFile, SecondRimsRoundTripAndMakeItVersion4) {
    const TempFolder folder;
    SurfelTreeData data = some_model();
    const PackedRims rims{pack_rim(3, 0.2), pack_rim(30, 0.5)};
    data.nodes[2].set_rims(rims);
    write_model(folder.file("m"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 4);
    EXPECT_EQ(ModelFile::open(folder.file("m")).tree().surfel(2).rims, rims);
    data.nodes[2].set_rims({0, rims.second});
    write_model(folder.file("m"), data, "{}");
    EXPECT_NE(error_of([&] { ModelFile::open(folder.file("m")); }).find("without a first"),
              std::string::npos);
}

/// A root with planes below it in a file of cubics.
SurfelTreeData some_mixed_model() {
    SurfelTreeData data = some_model();
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < data.nodes.size(); ++i) surfels.push_back(data.view().surfel(i));
    data.header.degree = 3;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        surfels[i].degree = static_cast<int>(i);
        for (std::size_t k = 1; k < kMaxCoefficients; ++k)
            if (k >= static_cast<std::size_t>(n_coefficients(surfels[i].degree)))
                surfels[i].polynomial.a[k] = 0;
        data.nodes[i].degree = i & 3u;
    }
    encode_surfels(surfels, data);
    return data;
}

TEST(ModelFile, SharpSurfelsRoundTripAndMakeItVersion2) {
    const TempFolder folder;
    write_model(folder.file("smooth"), some_model(), "{}");
    write_model(folder.file("m"), some_sharp_model(), "{}");
    EXPECT_EQ(read_bytes(folder.file("smooth"))[8], 1);
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 2);
    const ModelFile model = ModelFile::open(folder.file("m"));
    const SurfelTree tree = model.tree();
    EXPECT_FALSE(tree.surfel(1).sharp);
    ASSERT_TRUE(tree.surfel(2).sharp);
    expect_equal(*tree.surfel(2).sharp, *some_sheets(2));
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

TEST(ModelFile, CornersOfManySheetsRoundTripAndMakeItVersion5) {
    const TempFolder folder;
    for (std::size_t n_extra = 3; n_extra < kMostSheets; ++n_extra) {
        SurfelTreeData data = some_sharp_model();
        std::vector<Surfel> surfels;
        for (std::size_t i = 0; i < data.nodes.size(); ++i)
            surfels.push_back(data.view().surfel(i));
        surfels[2].sharp = some_sheets(n_extra);
        encode_surfels(surfels, data);
        write_model(folder.file("m"), data, "{}");
        EXPECT_EQ(read_bytes(folder.file("m"))[8], 5);
        const ModelFile model = ModelFile::open(folder.file("m"));
        ASSERT_TRUE(model.tree().surfel(2).sharp);
        expect_equal(*model.tree().surfel(2).sharp, *some_sheets(n_extra));
    }
}

TEST(ModelFile, RecordsOfMixedDegreesRoundTripAndMakeItVersion3) {
    const TempFolder folder;
    const SurfelTreeData data = some_mixed_model();
    ASSERT_EQ(data.records.size(), 7u + 7u + 12u);
    write_model(folder.file("m"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 3);
    const ModelFile model = ModelFile::open(folder.file("m"));
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(model.tree().surfel(i).center, data.view().surfel(i).center);
        EXPECT_EQ(model.tree().surfel(i).polynomial.a, data.view().surfel(i).polynomial.a);
        EXPECT_EQ(model.tree().surfel(i).degree, static_cast<int>(i));
    }
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

TEST(ModelFile, RefusesAnIndexThatIsNone) {
    const TempFolder folder;
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_mixed_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        const std::string error = error_of([&] { ModelFile::open(folder.file("m")); });
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    expect("node 1: record begins at float 8, expected 7", [](auto& d) { d.in_page[1] = 8; });
    expect("record begins at float 10, expected 0", [](auto& d) { d.page_start[0] = 10; });
    expect("2 records in 1 pages", [](auto& d) { d.in_page.pop_back(); });
    expect("3 records in 0 pages", [](auto& d) { d.page_start.clear(); });
    expect("records need 26 floats, found 25", [](auto& d) { d.records.pop_back(); });
    expect("node 2: record begins at float 14, expected 19",
           [](auto& d) { d.nodes[1].degree = 2; });
    expect("is not finite",
           [](auto& d) { d.records[20] = std::numeric_limits<float>::infinity(); });
}

TEST(ModelFile, RefusesSheetsThatAreNone) {
    const TempFolder folder;
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_sharp_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        const std::string error = error_of([&] { ModelFile::open(folder.file("m")); });
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    expect("node 9 is not a sharp one", [](auto& d) { d.sharp[0].node = 9; });
    expect("node 1 is not a sharp one", [](auto& d) { d.sharp[0].node = 1; });
    expect("1 nodes are sharp, found 2", [](auto& d) { d.sharp.push_back(d.sharp[0]); });
    expect("0 nodes are sharp, found 1", [](auto& d) { d.nodes[2].flags = kLeaf; });
    expect("1 nodes are sharp, found 0", [](auto& d) { d.sharp.clear(); });
    expect("6 further sheets", [](auto& d) { d.sharp[0].n_extra = 6; });
    expect("0 further sheets", [](auto& d) { d.sharp[0].n_extra = 0; });
    expect("join 2", [](auto& d) { d.sharp[0].outer = 2; });
    expect("first sheet 1", [](auto& d) { d.sharp[0].first_sheet = 1; });
    expect("2 sheets need 16 floats, found 15", [](auto& d) { d.sheets.pop_back(); });
    expect("is no part of a sheet", [](auto& d) { d.sheets[8] = 1.5f; });
    expect("is no part of a sheet",
           [](auto& d) { d.sheets[5] = std::numeric_limits<float>::infinity(); });
}

TEST(ModelFile, RoundTripsThroughTheMappedFile) {
    const TempFolder folder;
    const SurfelTreeData data = some_model();
    write_model(folder.file("m"), data, "{}");
    ModelFile opened = ModelFile::open(folder.file("m"));
    const ModelFile model = std::move(opened);
    EXPECT_EQ(model.provenance_json(), "{}");
    EXPECT_EQ(model.header().origin, data.header.origin);
    EXPECT_EQ(model.header().bounds.hi, data.header.bounds.hi);
    EXPECT_EQ(model.header().mdl_threshold, 0.01);
    EXPECT_EQ(model.header().n_points, 110u);
    const SurfelTree tree = model.tree();
    ASSERT_EQ(tree.n_nodes(), 3u);
    EXPECT_EQ(tree.surfel(2).center, data.view().surfel(2).center);
    EXPECT_EQ(tree.surfel(2).polynomial.a, data.view().surfel(2).polynomial.a);
    EXPECT_TRUE(tree.node(1).is_leaf());
    write_model(folder.file("again"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m")), read_bytes(folder.file("again")));
}

TEST(ModelFile, BoxesOfWhatIsDrawnRoundTripInAnyVersion) {
    const TempFolder folder;
    SurfelTreeData data = some_model();
    write_model(folder.file("m"), data, "{}");
    EXPECT_TRUE(ModelFile::open(folder.file("m")).header().drawn.empty());  // as older files
    data.header.drawn = {{1, 0, 2}, {3, 4, 4}};
    data.header.drawn_loose = {{0, 0, 2}, {3, 4, 4}};
    write_model(folder.file("m"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 1);
    write_model_colors(folder.file("m"), std::vector<PackedColor>(3));
    for (const auto& open : {ModelFile::open, ModelFile::open_by_pages}) {
        const ModelFile model = open(folder.file("m"));
        EXPECT_EQ(model.header().drawn.lo, data.header.drawn.lo);
        EXPECT_EQ(model.header().drawn.hi, data.header.drawn.hi);
        EXPECT_EQ(model.header().drawn_loose.lo, data.header.drawn_loose.lo);
    }
}

TEST(ModelFile, HullsOfWhatIsDrawnRoundTripToAShareOfTheirBox) {
    const TempFolder folder;
    SurfelTreeData data = some_model();
    data.header.drawn = {{1, 0, 2}, {3, 4, 4}};
    data.header.drawn_loose = {{0, 0, 2}, {3, 4, 4}};
    data.header.hull = {{1, 0, 2}, {3, 4, 4}, {2.3, 0.7, 3.1}};
    data.header.loose_hull = {{0, 1, 2}};
    write_model(folder.file("m"), data, "{}");
    write_model_colors(folder.file("m"), std::vector<PackedColor>(3));
    for (const auto& open : {ModelFile::open, ModelFile::open_by_pages}) {
        const ModelFile model = open(folder.file("m"));
        const auto& hull = model.header().hull;
        ASSERT_EQ(hull.size(), 3u);
        EXPECT_EQ(hull[0], data.header.hull[0]);
        EXPECT_EQ(hull[1], data.header.hull[1]);
        EXPECT_LT(length(hull[2] - data.header.hull[2]), 1e-4);
        ASSERT_EQ(model.header().loose_hull.size(), 1u);
        EXPECT_LT(length(model.header().loose_hull[0] - data.header.loose_hull[0]), 1e-4);
    }
}

TEST(ModelFile, RefusesAHullOfNothingOrOfTooManyPlaces) {
    const TempFolder folder;
    for (const bool many : {false, true}) {
        SurfelTreeData data = some_model();
        data.header.drawn = {{1, 0, 2}, {3, 4, 4}};
        data.header.drawn_loose = {};
        (many ? data.header.hull : data.header.loose_hull).assign(many ? 387 : 1, {1, 0, 2});
        write_model(folder.file("m"), data, "{}");
        for (const auto& open : {ModelFile::open, ModelFile::open_by_pages}) {
            const std::string error = error_of([&] { open(folder.file("m")); });
            EXPECT_NE(error.find("hull: expected at most"), std::string::npos) << error;
        }
    }
}

TEST(ModelFile, RefusesBoxesOfWhatIsDrawnBeyondThePoints) {
    const TempFolder folder;
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const Bbox& box : {Bbox{{-1, 0, 0}, {1, 1, 1}}, Bbox{{0, 0, 0}, {1, 5, 1}},
                            Bbox{{0, 3, 0}, {1, 2, 1}}, Bbox{{0, 0, kNan}, {1, 1, 1}}}) {
        SurfelTreeData data = some_model();
        data.header.drawn = {{0, 0, 0}, {1, 1, 1}};
        data.header.drawn_loose = box;
        write_model(folder.file("m"), data, "{}");
        for (const auto& open : {ModelFile::open, ModelFile::open_by_pages}) {
            const std::string error = error_of([&] { open(folder.file("m")); });
            EXPECT_NE(error.find("chunk drawn"), std::string::npos) << error;
            EXPECT_NE(error.find("no part of the points' box"), std::string::npos) << error;
        }
    }
}

TEST(ModelFile, SeesEveryFlippedByteAndEveryTruncation) {
    const TempFolder folder;
    SurfelTreeData data = some_model();
    data.header.drawn = data.header.drawn_loose = {{1, 0, 2}, {3, 4, 4}};
    write_model(folder.file("m"), data, "{\"a\": 1}");
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

TEST(ModelFile, Row44RefusesTreesThatAreNone) {
    const TempFolder folder;
    const auto refusal = [&](const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        return error_of([&] { ModelFile::open(folder.file("m")); });
    };
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        const std::string error = refusal(spoil);
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(refusal([](SurfelTreeData&) {}), "");
    expect("node 0: children up to 4", [](auto& d) { d.nodes[0].n_children = 3; });
    expect("children up to", [](auto& d) { d.nodes[0].n_children = 0xffffffffu; });
    expect("node 2: has no parent", [](auto& d) { d.nodes[0].n_children = 1; });
    expect("does not follow its parent", [](auto& d) { d.nodes[0].first_child = 0; });
    expect("node 2: child 1",
           [](auto& d) { d.nodes[2].first_child = 1, d.nodes[2].n_children = 1; });
    expect("has another parent",
           [](auto& d) { d.nodes[1].first_child = 2, d.nodes[1].n_children = 1; });
    expect("is not finite", [&](auto& d) { d.records[12] = nan; });
    expect("support radius 0", [](auto& d) { d.records[12 + 3] = 0; });
    expect("node 0: bound radius 1 does not hold the ball of child 1", [](auto& d) {
        d.nodes[0].bound_radius = 1, d.records[3] = 1;
    });
    expect("node 1: bound radius", [](auto& d) { d.nodes[1].bound_radius = 0.25f; });
    expect("bound radius", [&](auto& d) { d.nodes[1].bound_radius = nan; });
    expect("degree 3 is above", [](auto& d) { d.nodes[1].degree = 3; });
    expect("says 3 leaves, found 2", [](auto& d) { d.header.n_leaves = 3; });
    expect("degree 4", [](auto& d) { d.header.degree = 4; });
    expect("need 2 pages", [](auto& d) {
        d.nodes.resize(1025);
        d.records.resize(1025 * 12);
    });
    expect("floats of records", [](auto& d) { d.records.pop_back(); });
    expect("found no node",
           [](auto& d) { d.nodes.clear(), d.records.clear(), d.page_origins.clear(); });
}

}  // namespace
}  // namespace slim::test
