// Pixels where several surfaces meet: how `edges` tells the last stage which neighbour shows the other surface, and how much of it.

// Right, left, down, up; then the corners.
const ivec2 NEIGHBOURS[8] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(1, 1), ivec2(-1, 1), ivec2(1, -1), ivec2(-1, -1));

// Shares are stored in so many parts, at most one less than all.
const int SHARE_PARTS = 32;

// What is stored in 8 bits: 0, or 1 + 8 * (parts of the other surface, less one) + number of the neighbour that shows it.
uint edge_code(int parts, int neighbour) { return parts <= 0 ? 0u : uint(1 + 8 * (min(parts, SHARE_PARTS - 1) - 1) + neighbour); }

// Whether a pixel has another surface; its share, and the neighbour that shows it.
bool decode_edge(float stored, out float share, out ivec2 neighbour) {
    int edge = int(stored * 255.0 + 0.5) - 1;
    share = float(edge / 8 + 1) / float(SHARE_PARTS);
    neighbour = NEIGHBOURS[max(edge, 0) % 8];
    return edge >= 0;
}
