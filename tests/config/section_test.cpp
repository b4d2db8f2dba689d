#include "vantage/config/section.h"

#include <functional>

#include <gtest/gtest.h>

#include "config_error.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

enum class Colour { kRed, kBlue };

const Range kSpeed{0.5, 10.0, "m/s"};

Section Parse(const std::string& text) {
  return ParseConfig({"file.yaml", "", text});
}

TEST(Section, ReadsEachType) {
  const Section root = Parse(R"(
number: 2.5
exponent: 1e0
plus: +3
angle_deg: 90
count: -7
flag: true
text: some words
quoted: "5"
vector: [1, 2, 3]
numbers: [1.5, 2]
integers: [4, 5]
colour: blue
child: {inner: 1}
children: [{inner: 2}, {inner: 3}]
)");
  EXPECT_EQ(root.Number("number", kSpeed, kRequired, ""), 2.5);
  EXPECT_EQ(root.Number("exponent", kSpeed, kRequired, ""), 1.0);
  EXPECT_EQ(root.Number("plus", kSpeed, kRequired, ""), 3.0);
  EXPECT_EQ(root.Degrees("angle_deg", {-180, 180, "deg"}, kRequired, ""), kPi / 2);
  EXPECT_EQ(root.Integer("count", -10, 10, kRequired, ""), -7);
  EXPECT_TRUE(root.Flag("flag", kRequired, ""));
  EXPECT_EQ(root.Text("text", kRequired, ""), "some words");
  EXPECT_EQ(root.Text("quoted", kRequired, ""), "5");
  EXPECT_EQ(root.Vector3("vector", {0, 9, "m"}, kRequired, ""), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(root.Numbers("numbers", {0, 9, ""}, 1, 3, ""), Eigen::Vector2d(1.5, 2.0));
  EXPECT_EQ(root.Integers("integers", 0, 9, 1, 2, ""), (std::vector<std::int64_t>{4, 5}));
  const Section::Names<Colour> colours{{"red", Colour::kRed}, {"blue", Colour::kBlue}};
  EXPECT_EQ(root.Choice<Colour>("colour", colours, kRequired, ""), Colour::kBlue);
  EXPECT_EQ(root.Child("child", "").Integer("inner", 0, 9, kRequired, ""), 1);
  const std::vector<Section> children = root.Children("children", 1, 2, "");
  ASSERT_EQ(children.size(), 2u);
  EXPECT_EQ(children[1].Integer("inner", 0, 9, kRequired, ""), 3);
  EXPECT_EQ(children[0].Integer("inner", 0, 9, kRequired, ""), 2);
  EXPECT_NO_THROW(root.RejectUnknownKeys());
}

TEST(Section, GivesDefaultsForAbsentKeys) {
  const Section root = Parse("other: 1");
  EXPECT_EQ(root.Number("number", kSpeed, 4.0, ""), 4.0);
  EXPECT_EQ(root.Degrees("angle_deg", {-180, 180, "deg"}, 180.0, ""), kPi);
  EXPECT_EQ(root.Integer("count", 0, 9, 3, ""), 3);
  EXPECT_FALSE(root.Flag("flag", false, ""));
  EXPECT_EQ(root.Text("text", "words", ""), "words");
  EXPECT_EQ(root.Vector3("vector", {0, 9, "m"}, Eigen::Vector3d(1, 2, 3), ""),
            Eigen::Vector3d(1, 2, 3));
  const Section::Names<Colour> colours{{"red", Colour::kRed}, {"blue", Colour::kBlue}};
  EXPECT_EQ(root.Choice<Colour>("colour", colours, Colour::kBlue, ""), Colour::kBlue);
  const Section child = root.OptionalChild("child", "");
  EXPECT_FALSE(child.present());
  EXPECT_EQ(child.Number("number", kSpeed, 4.0, ""), 4.0);
  EXPECT_TRUE(root.Children("children", 0, 2, "").empty());
}

TEST(Section, TellsTheFormOfAKey) {
  const Section root = Parse("a: 1\nb: [1]\nc: {d: 1}\n");
  EXPECT_EQ(root.FormOf("a"), Section::Form::kScalar);
  EXPECT_EQ(root.FormOf("b"), Section::Form::kList);
  EXPECT_EQ(root.FormOf("c"), Section::Form::kMapping);
  EXPECT_EQ(root.FormOf("d"), Section::Form::kAbsent);
}

TEST(Section, AcceptsTheBoundsThemselves) {
  const Section root = Parse("low: 0.5\nhigh: 10");
  EXPECT_EQ(root.Number("low", kSpeed, kRequired, ""), 0.5);
  EXPECT_EQ(root.Number("high", kSpeed, kRequired, ""), 10.0);
}

struct Refusal {
  const char* name;
  const char* text;
  std::function<void(const Section&)> read;
  const char* message;
};

class SectionRefuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(SectionRefuses, WithFileLineKeyAndBound) {
  const Section root = Parse(GetParam().text);
  EXPECT_EQ(test::ConfigErrorOf([&] { GetParam().read(root); }), GetParam().message);
}

void ReadSpeed(const Section& s) {
  (void)s.Number("speed", kSpeed, kRequired, "");
}
void ReadCount(const Section& s) {
  (void)s.Integer("count", 1, 5, kRequired, "");
}
void ReadFlag(const Section& s) {
  (void)s.Flag("flag", kRequired, "");
}
void ReadText(const Section& s) {
  (void)s.Text("text", kRequired, "");
}
void ReadVector(const Section& s) {
  (void)s.Vector3("v", {0, 9, "m"}, kRequired, "");
}
void ReadChild(const Section& s) {
  ReadSpeed(s.Child("child", ""));
}
void ReadChildren(const Section& s) {
  for (const Section& child : s.Children("list", 1, 2, "")) ReadSpeed(child);
}
void ReadColour(const Section& s) {
  (void)s.Choice<Colour>("colour", {{"red", Colour::kRed}, {"blue", Colour::kBlue}}, kRequired, "");
}
void ReadIntegers(const Section& s) {
  (void)s.Integers("list", 0, 3, 1, 2, "");
}

INSTANTIATE_TEST_SUITE_P(
    Numbers, SectionRefuses,
    ::testing::Values(
        Refusal{"Missing", "a: 1", ReadSpeed, "file.yaml:1: speed: missing"},
        Refusal{"TooSmall", "a: 1\nspeed: 0.49", ReadSpeed,
                "file.yaml:2: speed: must be in [0.5, 10] m/s, is 0.49"},
        Refusal{"TooLarge", "\n\nspeed: 1e3", ReadSpeed,
                "file.yaml:3: speed: must be in [0.5, 10] m/s, is 1e3"},
        Refusal{"NotANumber", "speed: .nan", ReadSpeed,
                "file.yaml:1: speed: must be in [0.5, 10] m/s, is .nan"},
        Refusal{"Infinite", "speed: .inf", ReadSpeed,
                "file.yaml:1: speed: must be in [0.5, 10] m/s, is .inf"},
        Refusal{"MinusInfinite", "speed: -.inf", ReadSpeed,
                "file.yaml:1: speed: must be in [0.5, 10] m/s, is -.inf"},
        Refusal{"Words", "speed: fast", ReadSpeed,
                "file.yaml:1: speed: must be a number, is 'fast'"},
        Refusal{"WordNan", "speed: nan", ReadSpeed,
                "file.yaml:1: speed: must be a number, is 'nan'"},
        Refusal{"Unit", "speed: 5 m/s", ReadSpeed,
                "file.yaml:1: speed: must be a number, is '5 m/s'"},
        Refusal{"DecimalComma", "speed: 1,5", ReadSpeed,
                "file.yaml:1: speed: must be a number, is '1,5'"},
        Refusal{"Quoted", "speed: \"5\"", ReadSpeed,
                "file.yaml:1: speed: must be a number, is '5'"},
        Refusal{"TooLargeForADouble", "speed: 1e999", ReadSpeed,
                "file.yaml:1: speed: must be a number, is '1e999'"},
        Refusal{"Empty", "speed:", ReadSpeed, "file.yaml:1: speed: must be a number, is empty"},
        Refusal{"List", "speed: [5]", ReadSpeed, "file.yaml:1: speed: must be a number, is a list"},
        Refusal{"Mapping", "speed: {a: 5}", ReadSpeed,
                "file.yaml:1: speed: must be a number, is a mapping"},
        Refusal{"LongText", "speed: aaaaaaaaaabbbbbbbbbbaaaaaaaaaabbbbbbbbbbaaaaaaaaaabbbbbbbbbbX",
                ReadSpeed,
                "file.yaml:1: speed: must be a number, is "
                "'aaaaaaaaaabbbbbbbbbbaaaaaaaaaabbbbbbbbbbaaaaaaaaaabbbbbbbbbb...'"},
        Refusal{"SeveralLines", "speed: \"a\\nb\"", ReadSpeed,
                "file.yaml:1: speed: must be a number, is 'a?b'"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Others, SectionRefuses,
    ::testing::Values(
        Refusal{"IntegerTooLarge", "count: 6", ReadCount,
                "file.yaml:1: count: must be in [1, 5], is 6"},
        Refusal{"IntegerFraction", "count: 2.5", ReadCount,
                "file.yaml:1: count: must be an integer, is '2.5'"},
        Refusal{"IntegerOverflow", "count: 99999999999999999999", ReadCount,
                "file.yaml:1: count: must be an integer, is '99999999999999999999'"},
        Refusal{"IntegerMissing", "a: 1", ReadCount, "file.yaml:1: count: missing"},
        Refusal{"FlagYes", "flag: yes", ReadFlag,
                "file.yaml:1: flag: must be true or false, is 'yes'"},
        Refusal{"FlagMissing", "a: 1", ReadFlag, "file.yaml:1: flag: missing"},
        Refusal{"TextEmpty", "text: \"\"", ReadText, "file.yaml:1: text: must be text, is empty"},
        Refusal{"TextList", "text: [a]", ReadText, "file.yaml:1: text: must be text, is a list"},
        Refusal{"TextControl", "text: \"a\\tb\"", ReadText,
                "file.yaml:1: text: must be one line without control characters, is 'a?b'"},
        Refusal{"TextMissing", "a: 1", ReadText, "file.yaml:1: text: missing"},
        Refusal{"VectorShort", "v: [1, 2]", ReadVector,
                "file.yaml:1: v: must be a list of 3 numbers, has 2"},
        Refusal{"VectorScalar", "v: 1", ReadVector,
                "file.yaml:1: v: must be a list of 3 numbers, is '1'"},
        Refusal{"VectorElement", "v: [1, 2,\n 10]", ReadVector,
                "file.yaml:2: v[2]: must be in [0, 9] m, is 10"},
        Refusal{"VectorElementType", "v: [1, x, 3]", ReadVector,
                "file.yaml:1: v[1]: must be a number, is 'x'"},
        Refusal{"VectorMissing", "a: 1", ReadVector, "file.yaml:1: v: missing"},
        Refusal{"ChildMissing", "a: 1", ReadChild, "file.yaml:1: child: missing"},
        Refusal{"ChildScalar", "child: 1", ReadChild,
                "file.yaml:1: child: must be a mapping, is '1'"},
        Refusal{"InChild", "a: 1\nchild:\n  speed: 0", ReadChild,
                "file.yaml:3: child.speed: must be in [0.5, 10] m/s, is 0"},
        Refusal{"MissingInChild", "a: 1\nchild:\n  fast: 0", ReadChild,
                "file.yaml:3: child.speed: missing"},
        Refusal{"InSecondElement", "list:\n  - {speed: 1}\n  - {speed: 0}", ReadChildren,
                "file.yaml:3: list[1].speed: must be in [0.5, 10] m/s, is 0"},
        Refusal{"TooManyElements", "list: [{}, {}, {}]", ReadChildren,
                "file.yaml:1: list: must be a list of 1 to 2 mappings, has 3"},
        Refusal{"NoElements", "list: []", ReadChildren,
                "file.yaml:1: list: must be a list of 1 to 2 mappings, has 0"},
        Refusal{"ElementOfOtherForm", "list: [1]", ReadChildren,
                "file.yaml:1: list[0]: must be a mapping, is '1'"},
        Refusal{"DuplicateInChild", "child:\n  speed: 1\n  speed: 2", ReadChild,
                "file.yaml:3: child.speed: is given twice"},
        Refusal{"DuplicateInElement", "list:\n  - {speed: 1, speed: 2}", ReadChildren,
                "file.yaml:2: list[0].speed: is given twice"},
        Refusal{"UnknownChoice", "colour: green", ReadColour,
                "file.yaml:1: colour: must be one of red, blue, is 'green'"},
        Refusal{"ChoiceMissing", "a: 1", ReadColour, "file.yaml:1: colour: missing"},
        Refusal{"IntegersElement", "list: [0, 4]", ReadIntegers,
                "file.yaml:1: list[1]: must be in [0, 3], is 4"},
        Refusal{"IntegersCount", "list: [0, 1, 2]", ReadIntegers,
                "file.yaml:1: list: must be a list of 1 to 2 integers, has 3"}),
    [](const auto& test) { return test.param.name; });

TEST(RejectUnknownKeys, NamesTheNearestKey) {
  const Section root = Parse("speed: 1\ncuont: 2");
  ReadSpeed(root);
  (void)root.Integer("count", 0, 9, 1, "");
  EXPECT_EQ(test::ConfigErrorOf([&] { root.RejectUnknownKeys(); }),
            "file.yaml:2: cuont: unknown key; did you mean 'count'?");
}

TEST(RejectUnknownKeys, ListsTheKnownKeysWhenNoneIsNear) {
  const Section root = Parse("speed: 1\ntemperature: 2");
  ReadSpeed(root);
  (void)root.Integer("count", 0, 9, 1, "");
  EXPECT_EQ(test::ConfigErrorOf([&] { root.RejectUnknownKeys(); }),
            "file.yaml:2: temperature: unknown key; known here: count, speed");
}

TEST(RejectUnknownKeys, LooksIntoChildrenAndLists) {
  const Section root = Parse("child: {speed: 1}\nlist:\n  - {speed: 1}\n  - {speed: 1, zzzzz: 2}");
  ReadChild(root);
  ReadChildren(root);
  EXPECT_EQ(test::ConfigErrorOf([&] { root.RejectUnknownKeys(); }),
            "file.yaml:4: list[1].zzzzz: unknown key; known here: speed");
}

TEST(RejectUnknownKeys, CountsAllReadsOfAChildAskedForTwice) {
  const Section root = Parse("child: {a: 1, b: 2}\nlist: [{a: 1, b: 2}]");
  for (const char* key : {"a", "b"}) {
    (void)root.Child("child", "").Integer(key, 0, 9, kRequired, "");
    (void)root.Children("list", 1, 1, "")[0].Integer(key, 0, 9, kRequired, "");
  }
  EXPECT_NO_THROW(root.RejectUnknownKeys());
}

TEST(Fail, NamesTheKeysLine) {
  const Section root = Parse("a: 1\nb: 2");
  EXPECT_EQ(test::ConfigErrorOf([&] { root.Fail("b", "does not fit"); }),
            "file.yaml:2: b: does not fit");
  EXPECT_EQ(test::ConfigErrorOf([&] { root.Fail("", "does not fit"); }),
            "file.yaml:1: does not fit");
}

struct BadText {
  const char* name;
  std::string text;
  const char* message;
};

class ParseConfigRefuses : public ::testing::TestWithParam<BadText> {};

TEST_P(ParseConfigRefuses, WithOneLine) {
  EXPECT_EQ(test::ConfigErrorOf([] { (void)Parse(GetParam().text); }), GetParam().message);
}

// Newer versions of the library name the anchor too.
TEST(ParseConfig, RefusesAnUnknownAlias) {
  const std::string error = test::ConfigErrorOf([] { (void)Parse("a: *b"); });
  EXPECT_EQ(error.rfind("file.yaml:1: not valid YAML: the referenced anchor is not defined", 0), 0u)
      << error;
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ParseConfigRefuses,
    ::testing::Values(
        BadText{"Nothing", "", "file.yaml: is empty"},
        BadText{"OnlyComments", "# nothing\n\n", "file.yaml: is empty"},
        BadText{"OnlyNull", "~", "file.yaml: is empty"},
        BadText{"Scalar", "hello", "file.yaml:1: must be a mapping, is 'hello'"},
        BadText{"List", "- 1\n- 2", "file.yaml:1: must be a mapping, is a list"},
        BadText{"TwoDocuments", "a: 1\n---\nb: 2", "file.yaml: must be one YAML document, holds 2"},
        BadText{"Duplicate", "a: 1\nb: 2\na: 3", "file.yaml:3: a: is given twice"},
        BadText{"OpenBracket", "a: [1, 2\nb: 3",
                "file.yaml:2: not valid YAML: end of sequence flow not found"},
        BadText{"Tab", "a:\n\tb: 1",
                "file.yaml:2: not valid YAML: illegal map value (the line is indented by a "
                "tab: use spaces)"},
        BadText{"KeyThatIsNoText", "? [a, b]\n: 1",
                "file.yaml:1: keys must be text, one is a list"},
        BadText{"NulByte", std::string("a: 1\0", 5), "file.yaml: is not a text file"}),
    [](const auto& test) { return test.param.name; });

TEST(ParseConfig, SurvivesDeepNesting) {
  const std::string text = "a: " + std::string(100000, '[');
  EXPECT_NE(test::ConfigErrorOf([&] { (void)Parse(text); }).find("not valid YAML"),
            std::string::npos);
}

TEST(SchemaRecorder, HearsOfEachReadOnceInOrder) {
  SchemaRecorder recorder;
  const Section root = ParseConfig({"file.yaml", "", "list: [{speed: 1}, {speed: 2}]"}, &recorder);
  ReadChildren(root);
  (void)root.OptionalChild("child", "A child.")
      .Degrees("angle_deg", {-180, 180, "deg"}, 45.0, "An angle.");
  const std::vector<SchemaEntry>& entries = recorder.entries();
  ASSERT_EQ(entries.size(), 4u);
  EXPECT_EQ(entries[0].path, "list");
  EXPECT_EQ(entries[0].type, "list of 1 to 2 sections");
  EXPECT_EQ(entries[1].path, "list[].speed");
  EXPECT_EQ(entries[1].type, "number");
  EXPECT_EQ(entries[1].unit, "m/s");
  EXPECT_EQ(entries[1].range, "[0.5, 10]");
  EXPECT_EQ(entries[1].fallback, "");
  EXPECT_EQ(entries[2].path, "child");
  EXPECT_EQ(entries[3].path, "child.angle_deg");
  EXPECT_EQ(entries[3].fallback, "45");
  EXPECT_EQ(entries[3].help, "An angle.");
}

TEST(SchemaRecorder, KeepsBothFormsOfAKey) {
  SchemaRecorder recorder;
  const Section root = ParseConfig({"file.yaml", "", "a: 1"}, &recorder);
  (void)root.Number("b", {0, 1, ""}, 0.5, "");
  (void)root.Text("b", "x", "");
  ASSERT_EQ(recorder.entries().size(), 1u);
  EXPECT_EQ(recorder.entries()[0].type, "number or text");
}

TEST(SchemaRecorder, KeepsATypeWhoseNameIsPartOfAnother) {
  SchemaRecorder recorder;
  recorder.Add({"a", "list of 3 numbers", "", "", "", ""});
  recorder.Add({"a", "number", "", "", "", ""});
  recorder.Add({"a", "number", "", "", "", ""});
  recorder.Add({"a", "list of 3 numbers", "", "", "", ""});
  ASSERT_EQ(recorder.entries().size(), 1u);
  EXPECT_EQ(recorder.entries()[0].type, "list of 3 numbers or number");
}

}  // namespace
}  // namespace vantage
