//! What a ray finds in a packet is what it finds alone, and what a search through everything finds.

use super::tests::{Numbers, jumble};
use super::*;
use crate::levels;
use crate::packet::{Packet, RAYS};
use crate::triangle::Axes;

/// Rays as they come together: through a lens onto a point, parallel, or any.
fn bundle(numbers: &mut Numbers, kind: usize) -> Vec<Ray> {
    let count = 1 + (numbers.next().abs() * 200.0) as usize;
    let (lens, focus) = (6.0 * numbers.vector(), 3.0 * numbers.vector());
    let spread = 10_f64.powf(2.0 * numbers.next() - 1.0);
    (0..count)
        .map(|_| match kind % 4 {
            0 => {
                let origin = lens + spread * numbers.vector();
                Ray::new(origin, focus + 0.01 * numbers.vector() - origin)
            }
            1 => Ray::new(lens + spread * numbers.vector(), focus),
            2 => Ray::new(lens, numbers.vector()),
            // Along an axis, where a slab test divides by 0
            _ => Ray::new(lens + spread * numbers.vector(), DVec3::AXES[kind / 4 % 3] * spread),
        })
        .collect()
}

/// Sorts rays into packets of one class each.
fn packets(rays: &[Ray]) -> Vec<Packet> {
    let mut all = Vec::new();
    for class in 0..Axes::CLASSES {
        let same: Vec<_> = rays.iter().filter(|ray| Axes::class_of(ray.direction) == class).collect();
        for rays in same.chunks(RAYS) {
            let mut packet = Packet::new(class);
            rays.iter().for_each(|ray| {
                packet.push(ray);
            });
            all.push(packet);
        }
    }
    all
}

#[test]
fn a_ray_finds_the_same_alone_in_any_company_and_by_search() {
    let mut numbers = Numbers(5);
    let geometry = jumble(&mut numbers);
    let mut search = Search::default();
    let (mut rays, mut hits) = (0, 0);
    for kind in 0..60 {
        for packet in packets(&bundle(&mut numbers, kind)) {
            let wanted: Vec<_> = (0..packet.count()).map(|lane| geometry.hit(&packet.ray(lane))).collect();
            for level in levels::all() {
                let mut packet = packet.clone();
                dispatch!(level, simd => {
                    packet.seal(simd);
                    search.first(simd, &geometry, &packet);
                });
                for (lane, wanted) in wanted.iter().enumerate() {
                    let ray = packet.ray(lane);
                    let found = geometry.surface(&ray, &search.found(lane));
                    assert_eq!(&found, wanted, "{level:?}, kind {kind}, {ray:?}");
                }
            }
            for (lane, wanted) in wanted.iter().enumerate() {
                assert_eq!(*wanted, geometry.hit_by_search(&packet.ray(lane)), "kind {kind}, {:?}", packet.ray(lane));
            }
            rays += wanted.len();
            hits += wanted.iter().flatten().count();
        }
    }
    assert!(hits > rays / 10 && rays > 2000, "{hits} of {rays} hit: the test would say little");
}

#[test]
fn a_packet_is_blocked_where_each_of_its_rays_is() {
    let mut numbers = Numbers(6);
    let mut geometry = jumble(&mut numbers);
    geometry.endless.clear(); // the floor would block half of them
    let mut search = Search::default();
    let mut counts = [0; 2];
    for kind in 0..60 {
        for packet in packets(&bundle(&mut numbers, kind)) {
            // Leave out what some of the rays hit first
            let mut skip = [-1; RAYS];
            let mut wanted = Vec::new();
            for lane in 0..packet.count() {
                let ray = packet.ray(lane);
                match geometry.hit(&ray) {
                    Some(hit) if lane % 2 == 0 && hit.primitive & Geometry::SHAPE == 0 => {
                        skip[lane] = hit.primitive as i32;
                    }
                    _ => {}
                }
                wanted.push(geometry.is_blocked(&ray, f64::INFINITY, skip[lane] as PrimitiveId));
                counts[usize::from(wanted[lane])] += 1;
            }
            for level in levels::all() {
                let mut packet = packet.clone();
                dispatch!(level, simd => {
                    packet.seal(simd);
                    search.any(simd, &geometry, &packet, &skip);
                });
                let found: Vec<_> = (0..packet.count()).map(|lane| search.is_blocked(lane)).collect();
                assert_eq!(found, wanted, "{level:?}, kind {kind}");
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 400), "{counts:?}: the test would say little");
}

#[test]
fn no_packet_slips_between_triangles_that_share_an_edge() {
    // A closed box of 6 x 2 x 8 x 8 triangles from inside, through its vertices and along its edges
    let mut triangles = Vec::new();
    for side in 0..6 {
        let at = |i: u32, j: u32| {
            let mut p = [0.0; 3];
            p[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
            p[(side / 2 + 1) % 3] = i as f32 / 4.0 - 1.0;
            p[(side / 2 + 2) % 3] = j as f32 / 4.0 - 1.0;
            Vec3::from_array(p)
        };
        for i in 0..8 {
            for j in 0..8 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.push(Triangle { corners: [a, b, c], material: 0 });
                triangles.push(Triangle { corners: [a, c, d], material: 0 });
            }
        }
    }
    let geometry = Geometry::new(triangles.clone(), Vec::new()).unwrap();
    let mut numbers = Numbers(7);
    let mut search = Search::default();
    for _ in 0..40 {
        let eye = (0.5 * numbers.vector()).as_vec3();
        let rays: Vec<_> = triangles
            .iter()
            .flat_map(|triangle| {
                let [a, b, c] = triangle.corners;
                [a, 0.5 * (a + b), 0.25 * a + 0.75 * c, b]
            })
            .map(|target| Ray::single(eye, target - eye))
            .collect();
        for mut packet in packets(&rays) {
            dispatch!(geometry.level, simd => {
                packet.seal(simd);
                search.first(simd, &geometry, &packet);
            });
            for lane in 0..packet.count() {
                assert_ne!(search.found(lane).primitive, Geometry::NO_PRIMITIVE, "{:?} left the box", packet.ray(lane));
            }
        }
    }
}

#[test]
fn equal_triangles_are_told_apart_in_the_same_way_by_all() {
    // Twenty copies of one triangle, in different leaves: the one with the lowest name wins
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let geometry = Geometry::new(vec![Triangle { corners, material: 0 }; 20], Vec::new()).unwrap();
    let ray = Ray::single(Vec3::new(0.2, 0.3, 5.0), Vec3::NEG_Z);
    let hit = geometry.hit(&ray).unwrap();
    assert_eq!(hit.primitive, 0);
    assert_eq!(Some(hit), geometry.hit_by_search(&ray));
    let mut packet = packets(&[ray; 9]).remove(0);
    let mut search = Search::default();
    dispatch!(geometry.level, simd => {
        packet.seal(simd);
        search.first(simd, &geometry, &packet);
    });
    assert!((0..9).all(|lane| search.found(lane).primitive == 0));
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let mut numbers = Numbers(8);
    let triangles: Vec<_> = (0..70_000)
        .map(|_| {
            let centre = 40.0 * numbers.vector();
            Triangle { corners: [0, 1, 2].map(|_| (centre + 0.3 * numbers.vector()).as_vec3()), material: 0 }
        })
        .collect();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let geometry = pool.install(|| Geometry::new(triangles.clone(), Vec::new()).unwrap());
        format!("{:?} {:?}", geometry.bvh, geometry.packs)
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}
