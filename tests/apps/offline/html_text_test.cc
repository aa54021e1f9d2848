#include "apps/offline/html_text.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

TEST(HtmlText, MarkupIsShownAsItIs) {
  EXPECT_EQ(ForHtml("<b>&\"x\""), "&lt;b&gt;&amp;&quot;x&quot;");
  EXPECT_EQ(ForHtml("a\xff"), "a\xef\xbf\xbd");
}

// RFC 4648, section 10.
TEST(HtmlText, Base64IsTheStandards) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace arborslam
