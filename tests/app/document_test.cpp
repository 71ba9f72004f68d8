#include "tendril/app/document.hpp"

#include <gtest/gtest.h>

#include "support/contains.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {
namespace {

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

std::string message_of(const std::string& text) {
  try {
    Document::parse(text, "s.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Document, KnowsWhereEveryKeyStands) {
  const Document document = Document::parse("a = 1\n[t]\n  b = \"x\"\n[[u]]\nc = [1,\n 2]\n[[u]]\nd = 3\n", "s.toml");
  EXPECT_EQ(document.describe(document.find("a")), "s.toml:1:5");
  EXPECT_EQ(document.describe(document.find("t.b")), "s.toml:3:7");
  EXPECT_EQ(document.describe(document.find("u[0].c[1]")), "s.toml:6:2");
  EXPECT_EQ(document.describe(document.find("u[1].d")), "s.toml:8:5");
  // A key that is not there is answered with the table around it.
  EXPECT_EQ(document.describe(document.find("u[1].missing")), document.describe(document.find("u[1]")));
  EXPECT_EQ(document.find("u[1]").line, 7);
  EXPECT_EQ(document.describe(document.find("nothing[3].at.all")), "s.toml:1:1");
}

TEST(Document, ComesBackFromItsText) {
  const std::string text =
      "title = \"a \\\"b\\\" \\u0001\"\nlist = [1, 2.0, [true, \"x\"], {k = 1e-4}]\n\"odd key\" = 1e300\n\n[t]\nlast = "
      "0.1\n\n[t.inner]\n\n[[u]]\nc = 3\n\n[[u.v]]\nd = -4.0\n\n[[u]]\n";
  const std::string written = text_of(Document::parse(text, "s.toml"));
  EXPECT_EQ(text_of(Document::parse(written, "s.toml")), written);
  const Document document = Document::parse(written, "s.toml");
  EXPECT_EQ(std::get<std::string>(document.root().find("title")->value), std::string("a \"b\" \x01"));
  EXPECT_EQ(std::get<double>(document.root().find("odd key")->value), 1e300);
  EXPECT_EQ(document.find("u[0].v[0].d").line, 14);
  EXPECT_THROW(text_of(Document::parse("day = 2020-01-01\n", "s.toml")), InputError);
}

TEST(Document, TakesSixtyFourLevelsAndNotOneMore) {
  EXPECT_EQ(message_of("a" + repeated(".a", 63) + " = 1"), "");
  EXPECT_TRUE(contains_text(message_of("a" + repeated(".a", 64) + " = 1"), "nested deeper than 64"));
  EXPECT_EQ(message_of("[a" + repeated(".a", 31) + "]\nb" + repeated(".b", 31) + " = 1"), "");
  EXPECT_TRUE(
      contains_text(message_of("[a" + repeated(".a", 31) + "]\nb" + repeated(".b", 32) + " = 1"), "nested deeper"));
  EXPECT_EQ(message_of("a = " + repeated("[", 63) + repeated("]", 63)), "");
  EXPECT_TRUE(contains_text(message_of("a = " + repeated("[", 64) + repeated("]", 64)), "nested deeper"));
}

// Each of these overflows the stack of the parser itself.
TEST(Document, SurvivesVeryDeepNesting) {
  constexpr int deep = 200'000;
  for (const std::string& text :
       {"a" + repeated(".a", deep) + " = 1", "[a" + repeated(".a", deep) + "]", "[[a" + repeated(".a", deep) + "]]",
        "\"a\"" + repeated(" . 'a'", deep) + " = 1", "a = " + repeated("[", deep), "a = " + repeated("{a=", deep),
        "a = " + repeated("[{a.b=", deep)}) {
    EXPECT_TRUE(contains_text(message_of(text), "nested deeper than 64")) << text.substr(0, 20);
  }
}

TEST(Document, DoesNotMistakeTextForNesting) {
  const std::string noise = repeated("[{.", 100);
  EXPECT_EQ(message_of("a = \"" + noise + "\""), "");
  EXPECT_EQ(message_of("a = '" + noise + "'"), "");
  EXPECT_EQ(message_of("a = \"\"\"\n" + noise + "\n\\\"\"\"\" # " + noise), "");
  EXPECT_EQ(message_of("a = '''" + noise + "\n'''\nb = 1 # \"" + noise), "");
  EXPECT_EQ(message_of("\"" + noise + "\" = 1"), "");
  EXPECT_EQ(message_of("a = [" + repeated("1.5, ", 100) + "]\nb = {c = 1.5, d = 2.5}\n" + repeated("[x]\n", 0)), "");
}

TEST(Document, RefusesWhatIsNotToml) {
  EXPECT_EQ(message_of("hello world").rfind("s.toml:1:", 0), 0U);
  EXPECT_TRUE(contains_text(message_of("hello world"), "not TOML"));
  EXPECT_EQ(message_of("a = 1\na = 2").rfind("s.toml:2:", 0), 0U);
}

TEST(Document, RefusesBytesThatAreNotText) {
  EXPECT_NO_THROW(require_text("a = \"\u00b5\u20ac\U0001F600\"", "s"));
  for (const char* bad : {"\xff", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                          "\xf8\x88\x80\x80\x80", "\x80"}) {
    EXPECT_THROW(require_text(std::string("# \n") + bad, "s"), InputError);
  }
  EXPECT_THROW(require_text(std::string("a\0b", 3), "s"), InputError);
}

TEST(Settings, AreTomlOrElseText) {
  Document document = Document::parse("", "s.toml");
  document.apply({{"--set", "a", "0.5 N"},
                  {"--set", "b", "3"},
                  {"--set", "c", "[\"1 mm\", 2.5]"},
                  {"--set", "d", "true"},
                  {"--set", "e", "3", true}});
  EXPECT_EQ(std::get<std::string>(document.root().find("a")->value), "0.5 N");
  EXPECT_EQ(std::get<std::int64_t>(document.root().find("b")->value), 3);
  EXPECT_EQ(std::get<Node::List>(document.root().find("c")->value).size(), 2U);
  EXPECT_EQ(std::get<bool>(document.root().find("d")->value), true);
  EXPECT_EQ(std::get<std::string>(document.root().find("e")->value), "3");
}

TEST(Settings, ReplaceValuesAndMakeTables) {
  Document document = Document::parse("[[rod.actuator]]\nlimit = 1\n", "s.toml");
  document.apply({{"--set rod.actuator.0.limit=2", "rod.actuator.0.limit", "2"},
                  {"--set contact.mode=avoid", "contact.mode", "avoid"}});
  const Node& limit = std::get<Node::List>(document.root().find("rod")->find("actuator")->value)[0];
  EXPECT_EQ(std::get<std::int64_t>(limit.find("limit")->value), 2);
  EXPECT_EQ(std::get<std::string>(document.root().find("contact")->find("mode")->value), "avoid");
  // Errors name the argument and not the file.
  EXPECT_EQ(document.describe(document.find("contact.mode")), "--set contact.mode=avoid");
}

TEST(Settings, RefuseEntriesThatAreNotThere) {
  for (const char* key : {"rod.actuator.1.limit", "rod.actuator.x.limit", "rod.actuator.-1.limit", "obstacle.0.radius",
                          "rod.length.x", "", "rod..length", ".", "rod."}) {
    Document document = Document::parse("[rod]\nlength = 1\n[[rod.actuator]]\nlimit = 1\n", "s.toml");
    EXPECT_THROW(document.apply({{"--set", key, "1"}}), InputError) << key;
  }
}

TEST(Settings, SurviveVeryDeepKeysAndValues) {
  Document document = Document::parse("", "s.toml");
  EXPECT_THROW(document.apply({{"--set", "a" + repeated(".a", 200'000), "1"}}), InputError);
  document.apply({{"--set", "a", repeated("[", 200'000)}});
  EXPECT_TRUE(std::holds_alternative<std::string>(document.root().find("a")->value));
}

}  // namespace
}  // namespace tendril::app
