package vantage.spy;

import bot_core.image_metadata_t;
import bot_core.image_t;
import java.awt.Color;
import java.awt.image.BufferedImage;
import java.io.File;
import java.io.IOException;
import java.util.function.IntPredicate;
import javax.imageio.ImageIO;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;
import lcm.lcm.LCMSubscriber;
import vantage_msgs.image_features_t;
import vantage_msgs.observability_t;

/** The views paint what the messages say, and survive messages that say nonsense. Exit code 0: they do. */
public final class ViewTest {
  private static final int WIDTH = 900;
  private static final int HEIGHT = 560;
  private static int failures;

  private static void expect(boolean condition, String what) {
    if (condition) return;
    ++failures;
    System.out.println("FAILED: " + what);
  }

  private static void send(LCMSubscriber view, String channel, LCMEncodable message)
      throws IOException {
    LCMDataOutputStream out = new LCMDataOutputStream();
    message.encode(out);
    view.messageReceived((LCM) null, channel, new LCMDataInputStream(out.toByteArray()));
  }

  private static BufferedImage paint(ViewPlugin.View view, String name) throws IOException {
    view.setSize(WIDTH, HEIGHT);
    BufferedImage picture = new BufferedImage(WIDTH, HEIGHT, BufferedImage.TYPE_INT_RGB);
    view.paint(picture.getGraphics());
    ImageIO.write(picture, "png", new File(name));
    return picture;
  }

  private static int count(BufferedImage picture, int x0, int y0, int x1, int y1, IntPredicate what) {
    int found = 0;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        if (what.test(picture.getRGB(x, y) & 0xffffff)) ++found;
      }
    }
    return found;
  }

  private static boolean near(int rgb, Color colour) {
    Color c = new Color(rgb);
    return Math.abs(c.getRed() - colour.getRed()) < 40
        && Math.abs(c.getGreen() - colour.getGreen()) < 40
        && Math.abs(c.getBlue() - colour.getBlue()) < 40;
  }

  private static image_t image(int width, int height) {
    image_t image = new image_t();
    image.width = width;
    image.height = height;
    image.row_stride = width;
    image.pixelformat = image_t.PIXEL_FORMAT_GRAY;
    image.data = new byte[width * height];
    java.util.Arrays.fill(image.data, (byte) 100);
    image.size = image.data.length;
    image.metadata = new image_metadata_t[0];
    return image;
  }

  private static image_features_t features(double u, double v, boolean seen) {
    image_features_t features = new image_features_t();
    features.camera_orientation[0] = 1;
    features.num_markers = 2;
    features.id = new int[] {1, 2};
    features.u = new double[] {u, 10};
    features.v = new double[] {v, 10};
    features.valid = new int[] {seen ? 1 : 0, 1};
    return features;
  }

  private static void cameraView() throws IOException {
    CameraImageView view = new CameraImageView("X_CAMERA_IMAGE");
    Color green = new Color(60, 220, 60);
    Color red = new Color(240, 70, 60);
    paint(view, "nothing.png");
    send(view, "X_CAMERA_IMAGE", image(640, 480));
    // The window shows 640 x 480 at 7/6 of its size, 76 pixels from the left.
    int x = 76 + (int) (320.5 * 560 / 480);
    int y = (int) (240.5 * 560 / 480);
    for (int i = 0; i < 5; ++i) send(view, "X_IMAGE_FEATURES", features(280 + 10 * i, 240, true));
    BufferedImage picture = paint(view, "camera.png");
    expect(
        count(picture, x - 12, y - 12, x + 12, y + 12, c -> near(c, green)) > 20,
        "a green ring where a marker is seen");
    expect(picture.getRGB(700, 500) == new Color(100, 100, 100).getRGB(), "the image itself");
    expect(
        count(picture, x - 50, y - 2, x - 12, y + 3, c -> (c >> 8 & 255) > (c >> 16 & 255) + 10) > 20,
        "the path it came");
    send(view, "X_IMAGE_FEATURES", features(0, 0, false));
    picture = paint(view, "lost.png");
    expect(
        count(picture, x - 12, y - 12, x + 12, y + 12, c -> near(c, red)) > 20,
        "a red ring where a lost marker was last");
    // An image of half the size the features are in.
    CameraImageView half = new CameraImageView("CAMERA_IMAGE");
    send(half, "CAMERA_IMAGE", image(320, 240));
    send(half, "IMAGE_FEATURES", features(600, 450, true));
    send(half, "IMAGE_FEATURES", features(320, 240, true));
    picture = paint(half, "half.png");
    expect(
        count(picture, x - 12, y - 12, x + 12, y + 12, c -> near(c, green)) > 20,
        "features over an image of half their size");
    // Coordinates that no image has do not change the scale.
    for (double nonsense : new double[] {1e300, -1e9, Double.POSITIVE_INFINITY, Double.NaN, 16385}) {
      send(half, "IMAGE_FEATURES", features(nonsense, nonsense, true));
    }
    send(half, "IMAGE_FEATURES", features(320, 240, true));
    picture = paint(half, "nonsense.png");
    expect(
        count(picture, x - 12, y - 12, x + 12, y + 12, c -> near(c, green)) > 20,
        "coordinates that no image has are passed over");
    // Sizes that lie.
    image_t lie = image(10, 10);
    lie.height = 1000000;
    send(view, "X_CAMERA_IMAGE", lie);
    lie.height = -1;
    send(view, "X_CAMERA_IMAGE", lie);
    lie = image(10, 10);
    lie.pixelformat = image_t.PIXEL_FORMAT_MJPEG;
    send(view, "X_CAMERA_IMAGE", lie);
    view.messageReceived(null, "X_CAMERA_IMAGE", new LCMDataInputStream(new byte[3]));
    paint(view, "lies.png");
  }

  private static observability_t report(int i, int numSigma) {
    observability_t report = new observability_t();
    report.utime = 20000L * i;
    report.k = 8;
    report.m = 6;
    report.n = numSigma;
    report.w_v = 1e9 * Math.exp(0.02 * i);
    report.w_r = 0.05;
    report.w_c = 1e8 * Math.exp(0.02 * i);
    report.num_sigma = numSigma;
    report.rank = numSigma;
    report.sigma = new double[numSigma];
    for (int k = 0; k < numSigma; ++k) report.sigma[k] = 400 / Math.pow(2, k);
    report.axes = new double[0][8];
    report.threshold = 120;
    report.trigger_value = 60 + i;
    report.cause_name = "VIEW";
    report.active_state_name = "MOVING";
    report.active_reason_name = "LOW_MEASURE";
    return report;
  }

  private static void observabilityView() throws IOException {
    ObservabilityView view = new ObservabilityView("OBSERVABILITY");
    paint(view, "nothing.png");
    for (int i = 0; i < 100; ++i) send(view, "OBSERVABILITY", report(i, 6));
    BufferedImage picture = paint(view, "observability.png");
    Color[] curves = {
      new Color(0x22, 0x88, 0x33), new Color(0x44, 0x77, 0xaa), new Color(0xe0, 0x80, 0x30), new Color(0xaa, 0x33, 0x77)
    };
    for (int i = 0; i < curves.length; ++i) {
      Color colour = curves[i];
      int top = 34 + 131 * i;
      expect(
          count(picture, 60, top + 20, 520, top + 125, c -> near(c, colour)) > 20, "curve " + i);
    }
    expect(
        count(picture, 60, 54, 520, 160, c -> near(c, new Color(0xb9, 0x1c, 0x1c))) > 10,
        "the threshold");
    expect(
        count(picture, 560, 60, 880, 330, c -> near(c, new Color(0x44, 0x77, 0xaa))) > 200,
        "the ellipse");
    expect(
        count(picture, 560, 380, 880, 550, c -> near(c, new Color(0xe0, 0x80, 0x30))) > 100,
        "the bar of the least singular value");
    // Reports before the first image, of a singular arm, and of a servo started anew.
    ObservabilityView other = new ObservabilityView("OBSERVABILITY");
    observability_t empty = report(50, 0);
    empty.k = 0;
    send(other, "OBSERVABILITY", empty);
    paint(other, "empty.png");
    observability_t singular = report(60, 2);
    singular.sigma[1] = 0;
    singular.w_c = 0;
    singular.condition = Double.POSITIVE_INFINITY;
    singular.mm_per_px = Double.POSITIVE_INFINITY;
    send(other, "OBSERVABILITY", singular);
    send(other, "OBSERVABILITY", report(1, 1));
    paint(other, "singular.png");
    other.messageReceived(null, "OBSERVABILITY", new LCMDataInputStream(new byte[9]));
    paint(other, "garbage.png");
  }

  public static void main(String[] args) throws IOException {
    System.setProperty("java.awt.headless", "true");
    // What lcm-spy asks a plugin class for: an interface of its own, and a constructor without arguments.
    for (Class<?> plugin : new Class<?>[] {CameraImagePlugin.class, ObservabilityPlugin.class}) {
      try {
        lcm.spy.SpyPlugin made = (lcm.spy.SpyPlugin) plugin.getConstructor().newInstance();
        expect(plugin.getInterfaces().length == 1, plugin + " names SpyPlugin");
        expect(!made.canHandle(42), plugin + " leaves other types alone");
      } catch (ReflectiveOperationException error) {
        expect(false, plugin + ": " + error);
      }
    }
    expect(new CameraImagePlugin().canHandle(image_t.LCM_FINGERPRINT), "image_t");
    expect(new ObservabilityPlugin().canHandle(observability_t.LCM_FINGERPRINT), "observability_t");
    cameraView();
    observabilityView();
    System.exit(failures == 0 ? 0 : 1);
  }
}
