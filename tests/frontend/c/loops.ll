; ModuleID = 'loops.c'
source_filename = "loops.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @up(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp slt i32 %2, %1
  br i1 %4, label %7, label %5

5:                                                ; preds = %7, %3
  %6 = phi i32 [ 0, %3 ], [ %14, %7 ]
  ret i32 %6

7:                                                ; preds = %3, %7
  %8 = phi i32 [ %15, %7 ], [ %2, %3 ]
  %9 = phi i32 [ %14, %7 ], [ 0, %3 ]
  %10 = and i32 %8, 15
  %11 = zext i32 %10 to i64
  %12 = getelementptr inbounds i32, ptr %0, i64 %11
  %13 = load i32, ptr %12, align 4, !tbaa !5
  %14 = add nsw i32 %13, %9
  %15 = add nsw i32 %8, 1
  %16 = icmp eq i32 %15, %1
  br i1 %16, label %5, label %7, !llvm.loop !9
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @up_by_three(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %7, label %5

5:                                                ; preds = %7, %3
  %6 = phi i32 [ %2, %3 ], [ %14, %7 ]
  ret i32 %6

7:                                                ; preds = %3, %7
  %8 = phi i32 [ %15, %7 ], [ 0, %3 ]
  %9 = phi i32 [ %14, %7 ], [ %2, %3 ]
  %10 = and i32 %8, 15
  %11 = zext i32 %10 to i64
  %12 = getelementptr inbounds i32, ptr %0, i64 %11
  %13 = load i32, ptr %12, align 4, !tbaa !5
  %14 = add nsw i32 %13, %9
  %15 = add nuw nsw i32 %8, 3
  %16 = icmp slt i32 %15, %1
  br i1 %16, label %7, label %5, !llvm.loop !12
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @down(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp slt i32 %1, %2
  br i1 %4, label %5, label %7

5:                                                ; preds = %7, %3
  %6 = phi i32 [ 0, %3 ], [ %15, %7 ]
  ret i32 %6

7:                                                ; preds = %3, %7
  %8 = phi i32 [ %16, %7 ], [ %1, %3 ]
  %9 = phi i32 [ %15, %7 ], [ 0, %3 ]
  %10 = mul nsw i32 %9, 3
  %11 = and i32 %8, 15
  %12 = zext i32 %11 to i64
  %13 = getelementptr inbounds i32, ptr %0, i64 %12
  %14 = load i32, ptr %13, align 4, !tbaa !5
  %15 = add nsw i32 %14, %10
  %16 = add nsw i32 %8, -1
  %17 = icmp sgt i32 %8, %2
  br i1 %17, label %7, label %5, !llvm.loop !13
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @closed(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %2, %1
  br i1 %4, label %5, label %7

5:                                                ; preds = %7, %3
  %6 = phi i32 [ 0, %3 ], [ %15, %7 ]
  ret i32 %6

7:                                                ; preds = %3, %7
  %8 = phi i32 [ %16, %7 ], [ %2, %3 ]
  %9 = phi i32 [ %15, %7 ], [ 0, %3 ]
  %10 = and i32 %8, 15
  %11 = zext i32 %10 to i64
  %12 = getelementptr inbounds i32, ptr %0, i64 %11
  %13 = load i32, ptr %12, align 4, !tbaa !5
  %14 = add nsw i32 %13, %8
  %15 = xor i32 %14, %9
  %16 = add i32 %8, 1
  %17 = icmp eq i32 %8, %1
  br i1 %17, label %5, label %7, !llvm.loop !14
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @until(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = and i32 %1, 15
  %5 = icmp eq i32 %4, 0
  br i1 %5, label %8, label %6

6:                                                ; preds = %3
  %7 = zext i32 %4 to i64
  br label %10

8:                                                ; preds = %10, %3
  %9 = phi i32 [ 0, %3 ], [ %16, %10 ]
  ret i32 %9

10:                                               ; preds = %6, %10
  %11 = phi i64 [ 0, %6 ], [ %17, %10 ]
  %12 = phi i32 [ 0, %6 ], [ %16, %10 ]
  %13 = getelementptr inbounds i32, ptr %0, i64 %11
  %14 = load i32, ptr %13, align 4, !tbaa !5
  %15 = and i32 %14, %2
  %16 = add nsw i32 %15, %12
  %17 = add nuw nsw i64 %11, 1
  %18 = icmp eq i64 %17, %7
  br i1 %18, label %8, label %10, !llvm.loop !15
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @at_least_once(ptr nocapture noundef %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #1 {
  br label %4

4:                                                ; preds = %4, %3
  %5 = phi i32 [ %2, %3 ], [ %11, %4 ]
  %6 = and i32 %5, 15
  %7 = zext i32 %6 to i64
  %8 = getelementptr inbounds i32, ptr %0, i64 %7
  %9 = load i32, ptr %8, align 4, !tbaa !5
  %10 = add nsw i32 %9, %5
  store i32 %10, ptr %8, align 4, !tbaa !5
  %11 = add nsw i32 %5, 1
  %12 = icmp slt i32 %11, %1
  br i1 %12, label %4, label %13, !llvm.loop !16

13:                                               ; preds = %4
  ret i32 %11
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @unsigned_count(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = and i32 %2, 7
  %5 = and i32 %1, 31
  %6 = icmp ult i32 %4, %5
  br i1 %6, label %9, label %7

7:                                                ; preds = %9, %3
  %8 = phi i32 [ 0, %3 ], [ %16, %9 ]
  ret i32 %8

9:                                                ; preds = %3, %9
  %10 = phi i32 [ %17, %9 ], [ %4, %3 ]
  %11 = phi i32 [ %16, %9 ], [ 0, %3 ]
  %12 = and i32 %10, 15
  %13 = zext i32 %12 to i64
  %14 = getelementptr inbounds i32, ptr %0, i64 %13
  %15 = load i32, ptr %14, align 4, !tbaa !5
  %16 = add nsw i32 %15, %11
  %17 = add nuw nsw i32 %10, 1
  %18 = icmp eq i32 %17, %5
  br i1 %18, label %7, label %9, !llvm.loop !17
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @first(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %5, label %15

5:                                                ; preds = %3, %12
  %6 = phi i32 [ %13, %12 ], [ 0, %3 ]
  %7 = and i32 %6, 15
  %8 = zext i32 %7 to i64
  %9 = getelementptr inbounds i32, ptr %0, i64 %8
  %10 = load i32, ptr %9, align 4, !tbaa !5
  %11 = icmp eq i32 %10, %2
  br i1 %11, label %15, label %12

12:                                               ; preds = %5
  %13 = add nuw nsw i32 %6, 1
  %14 = icmp eq i32 %13, %1
  br i1 %14, label %15, label %5, !llvm.loop !18

15:                                               ; preds = %12, %5, %3
  %16 = phi i32 [ -1, %3 ], [ -1, %12 ], [ %6, %5 ]
  ret i32 %16
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @last_value(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %5, label %11

5:                                                ; preds = %3
  %6 = add i32 %1, 15
  %7 = and i32 %6, 15
  %8 = zext i32 %7 to i64
  %9 = getelementptr inbounds i32, ptr %0, i64 %8
  %10 = load i32, ptr %9, align 4, !tbaa !5
  br label %11

11:                                               ; preds = %5, %3
  %12 = phi i32 [ %10, %5 ], [ %2, %3 ]
  ret i32 %12
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @before_last(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %10, label %5

5:                                                ; preds = %10, %3
  %6 = phi i32 [ %2, %3 ], [ %12, %10 ]
  %7 = phi i32 [ 0, %3 ], [ %16, %10 ]
  %8 = mul nsw i32 %6, 5
  %9 = add nsw i32 %8, %7
  ret i32 %9

10:                                               ; preds = %3, %10
  %11 = phi i32 [ %17, %10 ], [ 0, %3 ]
  %12 = phi i32 [ %16, %10 ], [ 0, %3 ]
  %13 = and i32 %11, 15
  %14 = zext i32 %13 to i64
  %15 = getelementptr inbounds i32, ptr %0, i64 %14
  %16 = load i32, ptr %15, align 4, !tbaa !5
  %17 = add nuw nsw i32 %11, 1
  %18 = icmp eq i32 %17, %1
  br i1 %18, label %5, label %10, !llvm.loop !19
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @two_ways_out(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp slt i32 %2, %1
  br i1 %4, label %5, label %20

5:                                                ; preds = %3, %14
  %6 = phi i32 [ %12, %14 ], [ 0, %3 ]
  %7 = phi i32 [ %15, %14 ], [ %2, %3 ]
  %8 = and i32 %7, 15
  %9 = zext i32 %8 to i64
  %10 = getelementptr inbounds i32, ptr %0, i64 %9
  %11 = load i32, ptr %10, align 4, !tbaa !5
  %12 = add nsw i32 %11, %6
  %13 = icmp sgt i32 %12, 40
  br i1 %13, label %17, label %14

14:                                               ; preds = %5
  %15 = add i32 %7, 1
  %16 = icmp eq i32 %15, %1
  br i1 %16, label %17, label %5, !llvm.loop !20

17:                                               ; preds = %5, %14
  %18 = phi i32 [ %1, %14 ], [ %7, %5 ]
  %19 = mul nsw i32 %12, 100
  br label %20

20:                                               ; preds = %17, %3
  %21 = phi i32 [ %2, %3 ], [ %18, %17 ]
  %22 = phi i32 [ 0, %3 ], [ %19, %17 ]
  %23 = add nsw i32 %22, %21
  ret i32 %23
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @nested(ptr nocapture noundef %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #1 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %9, label %7

5:                                                ; preds = %15
  %6 = sub nsw i32 %16, %17
  br label %7

7:                                                ; preds = %5, %3
  %8 = phi i32 [ %6, %5 ], [ 0, %3 ]
  ret i32 %8

9:                                                ; preds = %3, %15
  %10 = phi i32 [ %13, %15 ], [ 0, %3 ]
  %11 = phi i32 [ %17, %15 ], [ 0, %3 ]
  %12 = phi i32 [ %16, %15 ], [ 0, %3 ]
  %13 = add nuw nsw i32 %10, 1
  %14 = icmp slt i32 %13, %2
  br i1 %14, label %25, label %15

15:                                               ; preds = %25, %9
  %16 = phi i32 [ %12, %9 ], [ %35, %25 ]
  %17 = phi i32 [ %11, %9 ], [ %32, %25 ]
  %18 = add nsw i32 %17, %16
  %19 = and i32 %10, 15
  %20 = zext i32 %19 to i64
  %21 = getelementptr inbounds i32, ptr %0, i64 %20
  %22 = load i32, ptr %21, align 4, !tbaa !5
  %23 = xor i32 %22, %18
  store i32 %23, ptr %21, align 4, !tbaa !5
  %24 = icmp eq i32 %13, %1
  br i1 %24, label %5, label %9, !llvm.loop !21

25:                                               ; preds = %9, %25
  %26 = phi i32 [ %36, %25 ], [ %13, %9 ]
  %27 = phi i32 [ %35, %25 ], [ %12, %9 ]
  %28 = add nuw nsw i32 %26, %10
  %29 = and i32 %28, 15
  %30 = zext i32 %29 to i64
  %31 = getelementptr inbounds i32, ptr %0, i64 %30
  %32 = load i32, ptr %31, align 4, !tbaa !5
  %33 = icmp eq i32 %32, 7
  %34 = select i1 %33, i32 0, i32 %32
  %35 = add nsw i32 %34, %27
  %36 = add nuw nsw i32 %26, 1
  %37 = icmp eq i32 %36, %2
  br i1 %37, label %15, label %25, !llvm.loop !22
}

; Function Attrs: nofree norecurse nosync nounwind memory(read, inaccessiblemem: none) uwtable
define dso_local i32 @pointers(ptr noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #2 {
  %4 = and i32 %1, 15
  %5 = zext i32 %4 to i64
  %6 = getelementptr inbounds i32, ptr %0, i64 %5
  %7 = icmp eq i32 %4, 0
  br i1 %7, label %8, label %11

8:                                                ; preds = %11, %3
  %9 = phi i32 [ %2, %3 ], [ %15, %11 ]
  %10 = icmp eq i32 %4, 0
  br i1 %10, label %18, label %20

11:                                               ; preds = %3, %11
  %12 = phi i32 [ %15, %11 ], [ %2, %3 ]
  %13 = phi ptr [ %16, %11 ], [ %0, %3 ]
  %14 = load i32, ptr %13, align 4, !tbaa !5
  %15 = add nsw i32 %14, %12
  %16 = getelementptr inbounds i32, ptr %13, i64 1
  %17 = icmp ult ptr %16, %6
  br i1 %17, label %11, label %8, !llvm.loop !23

18:                                               ; preds = %20, %8
  %19 = phi i32 [ %9, %8 ], [ %26, %20 ]
  ret i32 %19

20:                                               ; preds = %8, %20
  %21 = phi ptr [ %23, %20 ], [ %6, %8 ]
  %22 = phi i32 [ %26, %20 ], [ %9, %8 ]
  %23 = getelementptr inbounds i32, ptr %21, i64 -1
  %24 = mul nsw i32 %22, 3
  %25 = load i32, ptr %23, align 4, !tbaa !5
  %26 = add nsw i32 %25, %24
  %27 = icmp ugt ptr %23, %0
  br i1 %27, label %20, label %18, !llvm.loop !24
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @length(ptr nocapture noundef %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #1 {
  %4 = and i32 %1, 15
  %5 = zext i32 %4 to i64
  %6 = getelementptr inbounds i32, ptr %0, i64 %5
  store i32 0, ptr %6, align 4, !tbaa !5
  br label %7

7:                                                ; preds = %7, %3
  %8 = phi i64 [ 0, %3 ], [ %14, %7 ]
  %9 = getelementptr inbounds i32, ptr %0, i64 %8
  %10 = load i32, ptr %9, align 4, !tbaa !5
  %11 = icmp ne i32 %10, 0
  %12 = icmp ne i64 %8, 15
  %13 = select i1 %11, i1 %12, i1 false
  %14 = add nuw nsw i64 %8, 1
  br i1 %13, label %7, label %15, !llvm.loop !25

15:                                               ; preds = %7
  %16 = trunc i64 %8 to i32
  %17 = add nsw i32 %16, %2
  ret i32 %17
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @move_down(ptr nocapture noundef %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #1 {
  %4 = and i32 %1, 15
  %5 = and i32 %2, 7
  %6 = icmp ult i32 %5, %4
  br i1 %6, label %7, label %11

7:                                                ; preds = %3
  %8 = and i32 %2, 7
  %9 = zext i32 %8 to i64
  %10 = zext i32 %4 to i64
  br label %12

11:                                               ; preds = %12, %3
  ret void

12:                                               ; preds = %7, %12
  %13 = phi i64 [ %9, %7 ], [ %14, %12 ]
  %14 = add nuw nsw i64 %13, 1
  %15 = getelementptr inbounds i32, ptr %0, i64 %14
  %16 = load i32, ptr %15, align 4, !tbaa !5
  %17 = getelementptr inbounds i32, ptr %0, i64 %13
  store i32 %16, ptr %17, align 4, !tbaa !5
  %18 = icmp eq i64 %14, %10
  br i1 %18, label %11, label %12, !llvm.loop !26
}

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(argmem: readwrite) uwtable
define dso_local void @move_up(ptr nocapture noundef %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #3 {
  %4 = and i32 %2, 3
  %5 = zext i32 %4 to i64
  %6 = getelementptr inbounds i32, ptr %0, i64 %5
  %7 = shl i32 %1, 2
  %8 = and i32 %7, 28
  %9 = zext i32 %8 to i64
  tail call void @llvm.memmove.p0.p0.i64(ptr align 4 %6, ptr align 4 %0, i64 %9, i1 false)
  ret void
}

; Function Attrs: mustprogress nocallback nofree nounwind willreturn memory(argmem: readwrite)
declare void @llvm.memmove.p0.p0.i64(ptr nocapture writeonly, ptr nocapture readonly, i64, i1 immarg) #4

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: write) uwtable
define dso_local void @clear(ptr nocapture noundef writeonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #5 {
  %4 = and i32 %2, 3
  %5 = and i32 %1, 15
  %6 = icmp ult i32 %4, %5
  br i1 %6, label %7, label %17

7:                                                ; preds = %3
  %8 = shl i32 %2, 2
  %9 = and i32 %8, 12
  %10 = zext i32 %9 to i64
  %11 = getelementptr i8, ptr %0, i64 %10
  %12 = xor i32 %4, -1
  %13 = add nsw i32 %5, %12
  %14 = zext i32 %13 to i64
  %15 = shl nuw nsw i64 %14, 2
  %16 = add nuw nsw i64 %15, 4
  tail call void @llvm.memset.p0.i64(ptr noundef nonnull align 4 dereferenceable(1) %11, i8 0, i64 %16, i1 false), !tbaa !5
  br label %17

17:                                               ; preds = %7, %3
  ret void
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i64 @wide_counter(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %5, label %7

5:                                                ; preds = %3
  %6 = sext i32 %1 to i64
  br label %10

7:                                                ; preds = %10, %3
  %8 = phi i32 [ %2, %3 ], [ %16, %10 ]
  %9 = sext i32 %8 to i64
  ret i64 %9

10:                                               ; preds = %5, %10
  %11 = phi i64 [ %17, %10 ], [ %6, %5 ]
  %12 = phi i32 [ %16, %10 ], [ %2, %5 ]
  %13 = and i64 %11, 15
  %14 = getelementptr inbounds i32, ptr %0, i64 %13
  %15 = load i32, ptr %14, align 4, !tbaa !5
  %16 = add nsw i32 %15, %12
  %17 = add nsw i64 %11, -2
  %18 = icmp sgt i64 %11, 2
  br i1 %18, label %10, label %7, !llvm.loop !27
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @choose(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %5, label %26

5:                                                ; preds = %3, %22
  %6 = phi i32 [ %24, %22 ], [ 0, %3 ]
  %7 = phi i32 [ %23, %22 ], [ %2, %3 ]
  %8 = and i32 %6, 15
  %9 = zext i32 %8 to i64
  %10 = getelementptr inbounds i32, ptr %0, i64 %9
  %11 = load i32, ptr %10, align 4, !tbaa !5
  %12 = and i32 %11, 7
  switch i32 %12, label %20 [
    i32 0, label %13
    i32 1, label %15
    i32 2, label %17
    i32 3, label %26
  ]

13:                                               ; preds = %5
  %14 = add nsw i32 %7, 3
  br label %22

15:                                               ; preds = %5
  %16 = xor i32 %7, 5
  br label %17

17:                                               ; preds = %5, %15
  %18 = phi i32 [ %7, %5 ], [ %16, %15 ]
  %19 = sub nsw i32 %18, %6
  br label %22

20:                                               ; preds = %5
  %21 = add nsw i32 %7, 1
  br label %22

22:                                               ; preds = %13, %17, %20
  %23 = phi i32 [ %21, %20 ], [ %19, %17 ], [ %14, %13 ]
  %24 = add nuw nsw i32 %6, 1
  %25 = icmp eq i32 %24, %1
  br i1 %25, label %26, label %5, !llvm.loop !28

26:                                               ; preds = %22, %5, %3
  %27 = phi i32 [ %2, %3 ], [ %23, %22 ], [ %7, %5 ]
  ret i32 %27
}

; Function Attrs: nocallback nofree nounwind willreturn memory(argmem: write)
declare void @llvm.memset.p0.i64(ptr nocapture writeonly, i8, i64, i1 immarg) #6

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { nofree norecurse nosync nounwind memory(read, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #3 = { mustprogress nofree nosync nounwind willreturn memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #4 = { mustprogress nocallback nofree nounwind willreturn memory(argmem: readwrite) }
attributes #5 = { nofree norecurse nosync nounwind memory(argmem: write) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #6 = { nocallback nofree nounwind willreturn memory(argmem: write) }

!llvm.module.flags = !{!0, !1, !2, !3}
!llvm.ident = !{!4}

!0 = !{i32 1, !"wchar_size", i32 4}
!1 = !{i32 8, !"PIC Level", i32 2}
!2 = !{i32 7, !"PIE Level", i32 2}
!3 = !{i32 7, !"uwtable", i32 2}
!4 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!5 = !{!6, !6, i64 0}
!6 = !{!"int", !7, i64 0}
!7 = !{!"omnipotent char", !8, i64 0}
!8 = !{!"Simple C/C++ TBAA"}
!9 = distinct !{!9, !10, !11}
!10 = !{!"llvm.loop.mustprogress"}
!11 = !{!"llvm.loop.unroll.disable"}
!12 = distinct !{!12, !10, !11}
!13 = distinct !{!13, !10, !11}
!14 = distinct !{!14, !10, !11}
!15 = distinct !{!15, !10, !11}
!16 = distinct !{!16, !10, !11}
!17 = distinct !{!17, !10, !11}
!18 = distinct !{!18, !10, !11}
!19 = distinct !{!19, !10, !11}
!20 = distinct !{!20, !10, !11}
!21 = distinct !{!21, !10, !11}
!22 = distinct !{!22, !10, !11}
!23 = distinct !{!23, !10, !11}
!24 = distinct !{!24, !10, !11}
!25 = distinct !{!25, !10, !11}
!26 = distinct !{!26, !10, !11}
!27 = distinct !{!27, !10, !11}
!28 = distinct !{!28, !10, !11}
