package vantage.spy;

import bot_core.image_t;
import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Font;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.awt.image.BufferedImage;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.ArrayDeque;
import java.util.HashMap;
import java.util.Map;
import javax.imageio.ImageIO;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import vantage_msgs.image_features_t;

/**
 * The newest image, scaled to the window, with the markers of the newest features over it: green where they
 * are seen, red at their last place where they are not, and their paths of the last two seconds. Features
 * are in pixels of the camera; the image may be smaller, at a whole fraction of that size.
 */
final class CameraImageView extends ViewPlugin.View implements LCMSubscriber {
  private static final Color SEEN = new Color(60, 220, 60);
  private static final Color LOST = new Color(240, 70, 60);
  private static final Color PATH = new Color(120, 230, 160, 150);
  private static final int TRAIL = 120; // Images.
  private static final int MAX_SIDE = 16384; // [px]: what comes from outside may say anything.

  private final String imageChannel;
  private final String featuresChannel;
  private BufferedImage image;
  private String problem = "waiting for an image";
  private image_features_t features;
  private double featureWidth; // Of the camera the features are in [px].
  private final Map<Integer, double[]> lastSeen = new HashMap<>();
  private final Map<Integer, ArrayDeque<double[]>> paths = new HashMap<>();

  CameraImageView(String channel) {
    imageChannel = channel;
    featuresChannel = ViewPlugin.sibling(channel, "CAMERA_IMAGE", "IMAGE_FEATURES");
    setPreferredSize(new Dimension(640, 480));
  }

  @Override
  void start(LCM lcm) {
    lcm.subscribe(imageChannel, this);
    lcm.subscribe(featuresChannel, this);
  }

  @Override
  void stop(LCM lcm) {
    lcm.unsubscribe(imageChannel, this);
    lcm.unsubscribe(featuresChannel, this);
  }

  @Override
  public void messageReceived(LCM lcm, String channel, LCMDataInputStream stream) {
    try {
      if (channel.equals(imageChannel)) {
        take(new image_t(stream));
      } else {
        take(new image_features_t(stream));
      }
    } catch (IOException | RuntimeException error) {
      synchronized (this) {
        problem = "cannot read " + channel + ": " + error.getMessage();
      }
    }
    repaint();
  }

  private synchronized void take(image_t message) throws IOException {
    BufferedImage decoded = decode(message);
    if (decoded == null) {
      problem = "an image in a format that is not known here";
      return;
    }
    image = decoded;
    problem = null;
    if (featureWidth == 0) featureWidth = image.getWidth();
  }

  private synchronized void take(image_features_t message) {
    features = message;
    for (int i = 0; i < message.num_markers; ++i) {
      ArrayDeque<double[]> path = paths.computeIfAbsent(message.id[i], id -> new ArrayDeque<>());
      boolean seen = message.valid[i] != 0 && inAnImage(message.u[i]) && inAnImage(message.v[i]);
      double[] place = seen ? new double[] {message.u[i], message.v[i]} : null;
      path.addLast(place == null ? new double[0] : place);
      if (path.size() > TRAIL) path.removeFirst();
      if (place == null) continue;
      lastSeen.put(message.id[i], place);
      // The image may be scaled down by a half or a quarter: features tell.
      while (image != null && (place[0] > featureWidth || place[1] > featureHeight())) featureWidth *= 2;
    }
  }

  // Also false for NaN.
  private static boolean inAnImage(double pixel) {
    return Math.abs(pixel) <= MAX_SIDE;
  }

  private double featureHeight() {
    return featureWidth * image.getHeight() / image.getWidth();
  }

  private static BufferedImage decode(image_t message) throws IOException {
    if (message.pixelformat == image_t.PIXEL_FORMAT_MJPEG) {
      return ImageIO.read(new ByteArrayInputStream(message.data));
    }
    boolean grey = message.pixelformat == image_t.PIXEL_FORMAT_GRAY;
    if (!grey && message.pixelformat != image_t.PIXEL_FORMAT_RGB) return null;
    int width = message.width;
    int height = message.height;
    int bytes = grey ? 1 : 3;
    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE) return null;
    long needed = (long) message.row_stride * (height - 1) + (long) bytes * width;
    if (message.row_stride < bytes * width || needed > message.data.length) return null;
    BufferedImage picture = new BufferedImage(width, height, BufferedImage.TYPE_INT_RGB);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        int at = y * message.row_stride + bytes * x;
        int r = message.data[at] & 255;
        int g = grey ? r : message.data[at + 1] & 255;
        int b = grey ? r : message.data[at + 2] & 255;
        picture.setRGB(x, y, r << 16 | g << 8 | b);
      }
    }
    return picture;
  }

  @Override
  protected synchronized void paintComponent(Graphics graphics) {
    Graphics2D g = (Graphics2D) graphics;
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_STROKE_CONTROL, RenderingHints.VALUE_STROKE_PURE);
    g.setRenderingHint(
        RenderingHints.KEY_INTERPOLATION, RenderingHints.VALUE_INTERPOLATION_BILINEAR);
    g.setColor(new Color(24, 28, 32));
    g.fillRect(0, 0, getWidth(), getHeight());
    if (image != null) {
      double scale =
          Math.min((double) getWidth() / image.getWidth(), (double) getHeight() / image.getHeight());
      int width = (int) Math.round(scale * image.getWidth());
      int height = (int) Math.round(scale * image.getHeight());
      int left = (getWidth() - width) / 2;
      int top = (getHeight() - height) / 2;
      g.drawImage(image, left, top, width, height, null);
      g.translate(left, top);
      paintFeatures(g, width / featureWidth);
      g.translate(-left, -top);
    }
    if (problem != null) {
      g.setColor(Color.WHITE);
      g.drawString(problem, 12, 20);
    }
  }

  private void paintFeatures(Graphics2D g, double scale) {
    if (features == null) return;
    g.setColor(PATH);
    g.setStroke(new BasicStroke(1.2f));
    for (ArrayDeque<double[]> path : paths.values()) {
      double[] before = new double[0];
      for (double[] place : path) {
        if (before.length == 2 && place.length == 2) {
          g.draw(
              new Line2D.Double(
                  window(before[0], scale), window(before[1], scale),
                  window(place[0], scale), window(place[1], scale)));
        }
        before = place;
      }
    }
    g.setStroke(new BasicStroke(2f));
    g.setFont(g.getFont().deriveFont(Font.BOLD, 12f));
    int seen = 0;
    for (int i = 0; i < features.num_markers; ++i) {
      boolean valid = features.valid[i] != 0;
      if (valid) ++seen;
      double[] place = lastSeen.get(features.id[i]);
      if (place == null) continue;
      double x = window(place[0], scale);
      double y = window(place[1], scale);
      g.setColor(valid ? SEEN : LOST);
      g.draw(new Ellipse2D.Double(x - 8, y - 8, 16, 16));
      g.drawString(Integer.toString(features.id[i]), (float) x + 10, (float) y - 6);
    }
    g.setColor(Color.WHITE);
    g.drawString(seen + " of " + features.num_markers + " markers seen", 10, 18);
  }

  // Pixel 0 is the centre of the first pixel.
  private static double window(double pixel, double scale) {
    return (pixel + 0.5) * scale;
  }
}
